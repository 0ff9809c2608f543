"""The scheduler without MPI: a communicator of threads shows that every task is done once, in few messages."""

import queue
import threading
from dataclasses import dataclass, field

import numpy as np
import pytest

from kernel.method import choose
from sweep import messages
from sweep.batches import Batches
from sweep.master import Master
from sweep.schema import DONE, ROW
from sweep.tasks import Tasks
from sweep.worker import Job, OwnWorker, work

AXES = {"N": (5, 6, 7), "zeta_T": (1e-3, 1e-2), "M_over_M0": (0.5, 1.0, 2.0), "V_over_V0": (0.5, 1.0)}
JOB = Job(Tasks(AXES), choose("auto", 1e-2), certify=False)
TASKS = 36


@dataclass
class World:
    """What all ranks share: one queue per (receiver, tag), and a count of what was sent."""

    size: int
    queues: dict[tuple[int, int], queue.Queue] = field(default_factory=dict)
    sent: list[tuple[int, int, int]] = field(default_factory=list)  # (sender, receiver, tag)

    def queue(self, receiver: int, tag: int) -> queue.Queue:
        return self.queues.setdefault((receiver, tag), queue.Queue())


class Status:
    """The part of MPI.Status that the messages use."""

    def Get_source(self) -> int:
        return self.source

    def Get_count(self, _kind: object) -> int:
        return self.count


class Comm:
    """One rank's view; buffers are copied, as MPI does."""

    def __init__(self, world: World, rank: int) -> None:
        self.world, self.rank, self.size = world, rank, world.size
        self.early: dict[tuple[int, int], list] = {}

    def Send(self, buffer, receiver, tag):
        self.world.sent.append((self.rank, receiver, tag))
        self.world.queue(receiver, tag).put((self.rank, buffer.copy()))

    def Iprobe(self, source, tag, status):
        waiting = list(self.world.queue(self.rank, tag).queue)
        if not waiting:
            return False
        status.source, status.count = waiting[0][0], len(waiting[0][1])
        return True

    def Recv(self, buffer, source, tag):
        held = self.early.setdefault((source, tag), [])
        while not held:
            sender, content = self.world.queue(self.rank, tag).get(timeout=60)
            self.early.setdefault((sender, tag), []).append(content)
        buffer[...] = held.pop(0)


class Memory:
    """A writer that only remembers."""

    def __init__(self) -> None:
        self.rows, self.times = np.zeros(TASKS, ROW), np.zeros(TASKS, int)

    def write(self, ids, rows):
        self.rows[ids] = rows
        np.add.at(self.times, ids, 1)


def run_world(size: int, rows_come: bool, stopping=lambda: False):
    """All ranks as threads; (master, what was written, the world)."""
    world, memory = World(size), Memory()
    batches, own = Batches(np.arange(TASKS), np.linspace(0.001, 0.02, TASKS), size), OwnWorker(JOB)
    writer = None if rows_come else memory
    workers = [threading.Thread(target=work, args=(Comm(world, rank), JOB, writer)) for rank in range(1, size)]
    for worker in workers:
        worker.start()
    master = Master(Comm(world, 0), batches, own, memory, rows_come, stopping)
    master.run(lambda: None)
    for worker in workers:
        worker.join(60)
    own.close()
    assert not any(worker.is_alive() for worker in workers)
    return master, memory, world


@pytest.fixture(autouse=True)
def no_mpi(monkeypatch):
    from mpi4py import MPI

    monkeypatch.setattr(MPI, "Status", Status)


@pytest.mark.parametrize("rows_come", [True, False], ids=["gather", "mpio"])
@pytest.mark.parametrize("size", [2, 3, 5])
def test_every_task_is_done_and_written_exactly_once(size, rows_come):
    master, memory, _ = run_world(size, rows_come)
    assert (memory.times == 1).all()
    assert (memory.rows["status"] == DONE).all()
    for name, values in JOB.tasks.columns(np.arange(TASKS)).items():
        assert np.array_equal(memory.rows[name], values)
    assert (master.count.done, master.count.failed) == (TASKS, 0)


@pytest.mark.parametrize("rows_come", [True, False], ids=["gather", "mpio"])
def test_every_request_is_answered_and_a_batch_costs_two_or_three_messages(rows_come):
    size = 3
    _, memory, world = run_world(size, rows_come)
    tags = [tag for _, _, tag in world.sent]
    reports, answers, rows = (tags.count(tag) for tag in (messages.REPORT, messages.WORK, messages.ROWS))
    handed_out = answers - (size - 1)  # the last answer to each worker is empty
    assert reports == answers
    assert rows == (handed_out if rows_come else 0)
    assert handed_out <= np.count_nonzero(memory.rows["rank"]) <= TASKS
    assert {(sender, receiver) for sender, receiver, _ in world.sent} <= {(0, 1), (0, 2), (1, 0), (2, 0)}


@pytest.mark.parametrize("size", [1, 2, 4])
def test_a_stop_before_the_start_hands_out_nothing_and_releases_every_worker(size):
    master, memory, world = run_world(size, True, stopping=lambda: True)
    assert memory.times.sum() == master.count.done == 0
    assert len(world.sent) == 2 * (size - 1)


def test_a_stop_keeps_what_is_finished():
    seen = []
    master, memory, _ = run_world(2, True, stopping=lambda: len(seen) > 20 or seen.append(1) is not None)
    assert 0 < memory.times.sum() == master.count.done < TASKS
    assert memory.times.max() == 1


def test_an_error_in_rank_0s_own_thread_reaches_the_master(monkeypatch):
    def broken(*_):
        raise MemoryError("made up")

    monkeypatch.setattr("sweep.worker.compute_rows", broken)
    own = OwnWorker(JOB)
    master = Master(None, Batches(np.arange(3), np.ones(3), 1), own, Memory(), False)
    with pytest.raises(MemoryError, match="made up"):
        master.run(lambda: None)
    own.close()
