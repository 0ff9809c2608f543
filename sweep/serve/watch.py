"""Names the rank that died: one small process per node, because a launcher kills the other ranks at once.

    python watch.py HOST SOCKET RANK:PID ...

Run as a file, so that it starts in milliseconds. It ends when its input says so, or when it has named a rank.

A launcher kills the others when its own connection to a rank closes, and on a busy machine one of these may be gone
before the rank that died first. So every rank holds a connection to SOCKET, an open file that listens here. Linux
closes the newest file of a dying process first: this connection closes before the launcher's, which is older.
"""

import contextlib
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from typing import Any

ENDED = b"ended"
GONE_SECONDS = 2.0  # at most, from the end of a process's pipes to its own
LAUNCHER_SECONDS = 2.0  # for a launcher to end the job, before the ranks of this node are killed here


class NodeWatch:
    """Watches the ranks of this node from the start of a run to its end; collective."""

    def __init__(self, comm: Any) -> None:
        from mpi4py import MPI

        node = comm.Split_type(MPI.COMM_TYPE_SHARED)
        listening = _listening(node.size) if node.rank == 0 else None
        self._connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        address = node.bcast(listening.getsockname() if listening is not None else None)
        with contextlib.suppress(OSError):  # as of ranks in containers of their own: the end of the process counts
            self._connection.connect(address)
        pids = node.gather((comm.rank, os.getpid()))
        self._process = _start(listening, pids) if listening is not None else None
        self._pid: int | None = node.bcast(self._process.pid if self._process is not None else None)
        node.Free()

    def end(self) -> None:
        """End the watch: from now on ranks may end. All ranks call this before any of them ends."""
        if self._process is not None:
            self._process.communicate(ENDED)

    def close(self) -> None:
        """Close what this rank was watched by, once all ranks have ended the watch."""
        self._connection.close()

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


def _listening(ranks: int) -> socket.socket:
    """A socket that so many ranks of this node can connect to, by a name that Linux chooses and no file has."""
    listening = socket.socket(socket.AF_UNIX)
    listening.bind("")
    listening.listen(ranks)
    return listening


def _start(listening: socket.socket, pids: list[tuple[int, int]]) -> "subprocess.Popen[bytes] | None":
    ranks = (f"{rank}:{pid}" for rank, pid in pids)
    with listening:
        opened = listening.fileno()
        command = [sys.executable, "-I", "-S", __file__, os.uname().nodename, str(opened), *ranks]
        try:
            # A session of its own: a launcher that kills a rank's group does not reach it.
            return subprocess.Popen(command, stdin=subprocess.PIPE, pass_fds=(opened,), start_new_session=True)
        except OSError:
            return None


def main(host: str, opened: str, *ranks: str) -> None:
    """Wait for the first rank that ends, name it, and see to it that the others end too."""
    known: list[int] = []  # why the ranks end: one of them has said it, or a scheduler that ends all processes of a job
    for number in (signal.SIGINT, signal.SIGUSR1, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    for number in (signal.SIGUSR2, signal.SIGTERM):
        signal.signal(number, lambda came, _: known.append(came))
    rank_of = {int(pid): int(rank) for rank, pid in (each.split(":") for each in ranks)}
    connections = [each for each in _connected(int(opened)) if each[1] in rank_of]
    processes = list(_handles(rank_of))
    pid_of = dict(processes) | {connection.fileno(): pid for connection, pid in connections}
    waiting = select.epoll()  # gives the first that ended first, however many have by now
    for descriptor in (0, *pid_of):
        waiting.register(descriptor, select.EPOLLHUP | select.EPOLLIN)
    if not processes:
        return
    first, _ = waiting.poll(maxevents=1)[0]
    if first == 0:
        if os.read(0, len(ENDED)):
            return
        # Without b"ended" the rank that started this is dying, perhaps because a launcher kills it for another's sake.
        waiting.unregister(0)
        gone = waiting.poll(GONE_SECONDS, maxevents=1)
        first = gone[0][0] if gone else next(iter(pid_of))
    pid = pid_of[first]
    if not known:
        _say(
            f"sweep: rank {rank_of[pid]} on {host} (process {pid}) has died, which ends the job; "
            "what it had reported is kept, run again to go on\n"
        )
    _let_go()
    time.sleep(LAUNCHER_SECONDS)
    for handle, _ in processes:
        with contextlib.suppress(OSError):
            signal.pidfd_send_signal(handle, signal.SIGKILL)


def _connected(opened: int) -> Iterator[tuple[socket.socket, int]]:
    """The connections that were made, each with the process that made it."""
    with socket.socket(fileno=opened) as listening, contextlib.suppress(BlockingIOError):
        listening.setblocking(False)
        while True:
            connection, _ = listening.accept()
            known = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
            yield connection, struct.unpack("3i", known)[0]


def _handles(pids: Iterable[int]) -> Iterator[tuple[int, int]]:
    """An open file of each process that can be seen, which becomes readable when the process is gone."""
    for pid in pids:
        with contextlib.suppress(OSError):  # an old kernel, or processes that cannot see each other
            yield os.pidfd_open(pid), pid


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
