"""A rank that dies ends the job, is named, and costs nothing that was reported."""

import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from sweep.errors import InputError
from sweep.serve import watch
from sweep.tell import report

WAIT = 120.0


def watcher(*ranks: subprocess.Popen, listening: socket.socket | None = None) -> subprocess.Popen:
    """The watching process of a node that holds these, some of which may have connected to `listening`."""
    named = [f"{rank}:{process.pid}" for rank, process in enumerate(ranks)]
    with listening or watch._listening(len(ranks)) as opened:
        command = [sys.executable, "-I", "-S", watch.__file__, "node7", str(opened.fileno()), *named]
        return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, pass_fds=(opened.fileno(),))


def wait_until_it_watches(watching: subprocess.Popen, count: int) -> None:
    """Until it holds a handle of so many processes: on a busy machine its start takes longer than any fixed time."""
    end, seen = time.monotonic() + WAIT, 0
    while seen < count and time.monotonic() < end:
        time.sleep(0.02)
        seen = sum("pidfd" in target_of(handle) for handle in Path(f"/proc/{watching.pid}/fd").iterdir())


def target_of(handle: Path) -> str:
    """What an open file of a process is; nothing where it has been closed meanwhile."""
    try:
        return str(handle.readlink())
    except OSError:
        return ""


@pytest.fixture
def ranks():
    processes = [subprocess.Popen(["sleep", "1000"]) for _ in range(3)]
    yield processes
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.slow
def test_the_first_that_dies_is_named_and_takes_the_others_with_it(ranks):
    watching = watcher(*ranks)
    wait_until_it_watches(watching, len(ranks))
    ranks[1].kill()
    said = watching.stderr.read().decode()
    assert said.startswith(f"sweep: rank 1 on node7 (process {ranks[1].pid}) has died, which ends the job; ")
    assert said.count("\n") == 1
    assert [process.wait(WAIT) for process in ranks] == [-signal.SIGKILL] * 3
    assert watching.wait(WAIT) == 0
    watching.stdin.close()
    watching.stderr.close()


@pytest.mark.slow
def test_who_ends_without_a_word_has_died_and_who_says_so_has_not(ranks):
    for word, told in ((b"", True), (watch.ENDED, False)):
        _, said = watcher(*ranks).communicate(word, WAIT)
        assert (b"rank 0 on node7" in said) == told


@pytest.mark.slow
def test_who_is_gone_first_is_named_although_the_pipe_of_another_closed_before(ranks):
    """As where a launcher sees a dying rank's connection close, and kills the others before that rank is gone."""
    watching = watcher(*ranks)
    wait_until_it_watches(watching, len(ranks))
    watching.stdin.close()
    time.sleep(0.2)
    ranks[2].kill()
    ranks[2].wait(WAIT)  # a kill only asks: of two at once either may be gone first
    ranks[0].kill()
    said = watching.stderr.read()
    assert f"rank 2 on node7 (process {ranks[2].pid})".encode() in said
    assert watching.wait(WAIT) == 0
    watching.stderr.close()


CONNECTS = """
import socket, sys, time
made = [socket.socket(socket.AF_UNIX) for _ in sys.argv[1:]]
for each, name in zip(made, sys.argv[1:]):
    each.connect("\\0" + name)
print("connected", flush=True)
sys.stdin.read()
made[-1].close()
time.sleep(1000)
"""


@contextmanager
def connected(*listening: socket.socket) -> Iterator[subprocess.Popen]:
    """A rank that connects to these in turn, and closes the last connection at the end of its input."""
    names = [each.getsockname().decode()[1:] for each in listening]
    with subprocess.Popen(
        [sys.executable, "-c", CONNECTS, *names], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as rank:
        assert rank.stdout.readline() == b"connected\n"
        yield rank
        rank.kill()


@pytest.mark.slow
def test_of_a_process_that_dies_the_newest_connection_ends_first():
    """What the name of the first that died rests on: a launcher's connection is older than the watch's."""
    with watch._listening(1) as older, watch._listening(1) as newer, connected(older, newer) as rank:
        of_older, of_newer = older.accept()[0], newer.accept()[0]
        with of_older, of_newer, select.epoll() as ending:
            for each in (of_older, of_newer):
                ending.register(each, select.EPOLLIN)
            rank.kill()
            rank.wait(WAIT)
            assert [ending.poll(WAIT, maxevents=1)[0][0] for _ in range(2)] == [of_newer.fileno(), of_older.fileno()]


@pytest.mark.slow
def test_whose_connection_ends_first_is_named_although_another_is_gone_before():
    """As where a launcher kills the others while the rank that died first waits for a processor or a disk."""
    with watch._listening(2) as listening, connected(listening) as slow, connected(listening) as quick:
        watching = watcher(quick, slow, listening=listening)
        wait_until_it_watches(watching, 2)
        slow.stdin.close()
        time.sleep(0.2)
        quick.kill()
        said = watching.stderr.read()
        assert f"rank 1 on node7 (process {slow.pid})".encode() in said
        assert watching.wait(WAIT) == 0
        watching.stdin.close()
        watching.stderr.close()


def ranks_below(launcher: int) -> dict[int, int]:
    """The process of every rank of a launcher, from the environment that it was given."""
    found, todo = {}, [launcher]
    while todo:
        pid = todo.pop()
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        todo += map(int, children)
        environment = dict(
            item.split("=", 1)
            for item in Path(f"/proc/{pid}/environ").read_bytes().decode(errors="replace").split("\0")
            if "=" in item
        )
        if "PMI_RANK" in environment:
            found.setdefault(int(environment["PMI_RANK"]), pid)
    return found


@pytest.mark.mpi
@pytest.mark.parametrize("rank", [0, 2])
def test_a_killed_rank_is_named_and_running_again_completes_the_table(sweep, start, slow_spec, tmp_path, rank):
    process = start("run", slow_spec, "-o", "t.h5", ranks=3)
    done, until = 0, time.monotonic() + WAIT
    while not done and time.monotonic() < until:
        time.sleep(0.05)
        try:
            done = report.status(tmp_path / "t.h5")["done"]
        except InputError:
            done = 0
    victim = ranks_below(process.pid)[rank]
    os.kill(victim, signal.SIGKILL)
    _, said = process.communicate(timeout=WAIT)
    assert process.returncode != 0
    assert f"sweep: rank {rank} on {os.uname().nodename} (process {victim}) has died, which ends the job; " in said
    assert report.status(tmp_path / "t.h5")["done"] >= done > 0
    again = sweep("run", slow_spec, "-o", "t.h5", ranks=2)
    assert again.returncode == 0
    assert again.stdout.startswith("492 done, ")
    assert "has died" not in again.stderr
