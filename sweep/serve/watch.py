"""Names the rank that died: one small process per node, because a launcher kills the other ranks at once.

    python watch.py HOST RANK:PID ...

Run as a file, so that it starts in milliseconds. It ends when its input says so, or when it has named a rank.
"""

import contextlib
import os
import select
import signal
import subprocess
import sys
import time
from typing import Any

ENDED = b"ended"
GONE_SECONDS = 2.0  # at most, from the end of a process's pipes to its own
LAUNCHER_SECONDS = 2.0  # for a launcher to end the job, before the ranks of this node are killed here


class NodeWatch:
    """Watches the ranks of this node from the start of a run to its end; collective."""

    def __init__(self, comm: Any) -> None:
        from mpi4py import MPI

        node = comm.Split_type(MPI.COMM_TYPE_SHARED)
        pids = node.gather((comm.rank, os.getpid()))
        self._process = _start(pids) if pids is not None else None
        self._pid: int | None = node.bcast(self._process.pid if self._process is not None else None)
        node.Free()

    def end(self) -> None:
        """End the watch: from now on ranks may end. All ranks call this before any of them ends."""
        if self._process is not None:
            self._process.communicate(ENDED)

    def hush(self) -> None:
        """Let the watch see to it that all end, without naming who died: this rank is about to end the job."""
        if self._pid is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._pid, signal.SIGUSR2)

    def dismiss(self) -> None:
        """Kill the watch: this rank is about to end the job, and has said why."""
        if self._pid is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._pid, signal.SIGKILL)


def _start(pids: list[tuple[int, int]]) -> "subprocess.Popen[bytes] | None":
    command = [sys.executable, "-I", "-S", __file__, os.uname().nodename, *(f"{rank}:{pid}" for rank, pid in pids)]
    try:
        # A session of its own: a launcher that kills a rank's group does not reach it.
        return subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True)
    except OSError:
        return None


def main(host: str, *ranks: str) -> None:
    """Wait for the first rank that ends, name it, and see to it that the others end too."""
    known: list[int] = []  # why the ranks end: one of them has said it, or a scheduler that ends all processes of a job
    for number in (signal.SIGINT, signal.SIGUSR1, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    for number in (signal.SIGUSR2, signal.SIGTERM):
        signal.signal(number, lambda came, _: known.append(came))
    named: dict[int, tuple[int, int]] = {}
    waiting = select.epoll()  # gives the first that ended first, however many have by now
    waiting.register(0, select.EPOLLHUP | select.EPOLLIN)
    for rank, pid in (map(int, each.split(":")) for each in ranks):
        try:
            handle = os.pidfd_open(pid)
        except OSError:  # an old kernel, or processes that cannot see each other
            continue
        named[handle] = rank, pid
        waiting.register(handle, select.EPOLLIN)
    if not named:
        return
    first, _ = waiting.poll(maxevents=1)[0]
    if first == 0:
        if os.read(0, len(ENDED)):
            return
        # Without b"ended" the rank that started this is dying, perhaps because a launcher kills it for another's sake.
        # Pipes of a dying process close before the process is gone: the first that is gone is the first that died.
        waiting.unregister(0)
        gone = waiting.poll(GONE_SECONDS, maxevents=1)
        first = gone[0][0] if gone else next(iter(named))
    rank, pid = named[first]
    if not known:
        _say(
            f"sweep: rank {rank} on {host} (process {pid}) has died, which ends the job; "
            "what it had reported is kept, run again to go on\n"
        )
    _let_go()
    time.sleep(LAUNCHER_SECONDS)
    for handle in named:
        with contextlib.suppress(OSError):
            signal.pidfd_send_signal(handle, signal.SIGKILL)


def _say(line: str) -> None:
    with contextlib.suppress(OSError):
        sys.stderr.write(line)


def _let_go() -> None:
    """Close stdout and stderr: a launcher waits until no process has them open."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in (1, 2):
        os.dup2(nowhere, descriptor)


if __name__ == "__main__":
    main(*sys.argv[1:])
