"""The scheduler without MPI: a communicator of threads shows that every task is done once, in few messages."""

import math
import os
import queue
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from kernel.method import choose
from sweep.plan.batches import SECONDS_MIN, Batches
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, ROW
from sweep.serve import messages
from sweep.serve.master import Master
from sweep.serve.worker import Job, OwnWorker, Usage, work

AXES = {"N": (5, 6, 7), "zeta_T": (1e-3, 1e-2), "M_over_M0": (0.5, 1.0, 2.0), "V_over_V0": (0.5, 1.0)}
JOB = Job(Tasks(AXES), choose("auto", 1e-2), certify=False)
TASKS = 36
SECONDS = np.linspace(0.001, 0.02, TASKS)


@dataclass
class World:
    """What all ranks share: one queue per (receiver, tag), and a count of what was sent."""

    size: int
    queues: dict[tuple[int, int], queue.Queue] = field(default_factory=dict)
    sent: list[tuple[int, int, int]] = field(default_factory=list)  # (sender, receiver, tag)
    receives: list["Receive"] = field(default_factory=list)
    usages: list[Usage] = field(default_factory=list)  # of the workers

    def queue(self, receiver: int, tag: int) -> queue.Queue:
        return self.queues.setdefault((receiver, tag), queue.Queue())


class Status:
    """The part of MPI.Status that the messages use."""

    def Get_count(self, _kind: object) -> int:
        return self.count


class Receive:
    """A persistent receive."""

    def __init__(self, arrived: queue.Queue, buffer: np.ndarray) -> None:
        self.arrived, self.buffer, self.posted, self.freed = arrived, buffer, False, False

    def Start(self):
        assert not self.posted
        self.posted = True

    def Test(self, status):
        assert self.posted
        try:
            status.source, content = self.arrived.get(timeout=1e-3)
        except queue.Empty:
            return False
        status.count, self.posted = len(content), False
        self.buffer[: len(content)] = content
        return True

    def Cancel(self):
        self.posted = False

    def Wait(self):
        assert not self.posted

    def Free(self):
        assert not self.posted
        self.freed = True


class Comm:
    """One rank's view; buffers are copied, as MPI does."""

    def __init__(self, world: World, rank: int) -> None:
        self.world, self.rank, self.size = world, rank, world.size
        self.early: dict[tuple[int, int], list] = {}

    def Send(self, buffer, receiver, tag):
        self.world.sent.append((self.rank, receiver, tag))
        self.world.queue(receiver, tag).put((self.rank, buffer.copy()))

    def Recv_init(self, buffer, _source, tag):
        self.world.receives.append(Receive(self.world.queue(self.rank, tag), buffer[0]))
        return self.world.receives[-1]

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


def run_world(size: int, rows_come: bool, fits=lambda _: math.inf, computes: bool = True):
    """All ranks as threads; (master, what was written, the world)."""
    world, memory = World(size), Memory()
    batches = Batches(np.arange(TASKS), SECONDS, size)
    own = OwnWorker(JOB) if computes else None
    writer = None if rows_come else memory

    def worker_of(rank: int) -> None:
        world.usages.append(work(Comm(world, rank), JOB, writer))

    workers = [threading.Thread(target=worker_of, args=(rank,)) for rank in range(1, size)]
    for worker in workers:
        worker.start()
    master = Master(Comm(world, 0), batches, own, memory.write, rows_come, fits)
    master.run(lambda: None)
    for worker in workers:
        worker.join(60)
    if own is not None:
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
def test_a_batch_costs_two_messages_or_three_with_its_rows_and_the_end_one_per_worker(rows_come):
    size = 3
    master, memory, world = run_world(size, rows_come)
    tags = [tag for _, _, tag in world.sent]
    reports, answers, rows = (tags.count(tag) for tag in (messages.REPORT, messages.WORK, messages.ROWS))
    assert answers == reports + size - 1  # the last answer to each worker is empty
    assert reports == master.count.requests
    assert rows == (reports if rows_come else 0)
    assert reports <= np.count_nonzero(memory.rows["rank"]) <= TASKS
    assert {(sender, receiver) for sender, receiver, _ in world.sent} <= {(0, 1), (0, 2), (1, 0), (2, 0)}


@pytest.mark.parametrize("fits", [lambda _: math.inf, lambda _: 0.0], ids=["whole", "stopped"])
def test_no_rank_leaves_a_receive_behind_that_mpi_would_have_to_end_with(fits):
    _, _, world = run_world(3, True, fits)
    assert len(world.receives) == 3
    assert all(receive.freed for receive in world.receives)


def test_a_master_that_only_serves_leaves_all_rows_to_the_workers():
    _, memory, _ = run_world(3, True, computes=False)
    assert (memory.times == 1).all()
    assert set(memory.rows["rank"]) == {1, 2}


def test_the_books_balance_at_the_end():
    begun = time.perf_counter()
    master, memory, world = run_world(3, True)
    count, passed = master.count, time.perf_counter() - begun
    assert count.finished == pytest.approx(SECONDS.sum())
    assert abs(count.running) < 1e-9
    assert count.real - count.own == pytest.approx(sum(usage.busy for usage in world.usages), abs=1e-6 * TASKS)
    assert 3 * passed >= count.real >= memory.rows["seconds"].sum() > 0


@pytest.mark.parametrize("size", [1, 2, 4])
def test_a_stop_before_the_start_hands_out_nothing_and_releases_every_worker(size):
    master, memory, world = run_world(size, True, fits=lambda _: 0.0)
    assert memory.times.sum() == master.count.done == 0
    assert len(world.sent) == size - 1


def test_a_stop_keeps_what_is_finished():
    master, memory, _ = run_world(2, True, fits=lambda count: 0.0 if count.done > 3 else math.inf)
    assert 3 < memory.times.sum() == master.count.done < TASKS
    assert memory.times.max() == 1


def test_where_the_longest_do_not_fit_the_others_are_still_computed():
    _, memory, _ = run_world(2, True, fits=lambda _: 0.01)
    assert np.array_equal(memory.times == 1, SECONDS <= 0.01)


def test_who_waits_looks_some_times_then_sleeps_twice_as_long_each_time_until_a_message_comes(monkeypatch):
    slept, backoff = [], messages.Backoff()
    monkeypatch.setattr(messages.time, "sleep", slept.append)
    for _ in range(messages.LOOKS_BEFORE_SLEEP + 10):
        backoff.wait()
    assert slept == [min(messages.SLEEP_MAX, messages.SLEEP_MIN * 2**k) for k in range(10)]
    assert slept[-1] <= SECONDS_MIN / 20  # by which a message may be late: little of the shortest batch
    backoff.reset()
    backoff.wait()
    assert len(slept) == 10


@pytest.mark.parametrize("came", [0, 1, 2])
def test_a_master_who_has_served_anybody_looks_again_at_once(monkeypatch, came):
    master, left = Master(None, Batches(np.arange(1), np.ones(1), 1), None, Memory().write, True), iter(range(came))
    monkeypatch.setattr(master, "_answer", lambda *_: None)
    assert master._serve(SimpleNamespace(next=lambda: next(left, None))) == (came > 0)


def test_a_rank_counts_the_time_for_which_it_waits_and_no_other():
    usage, start, cpu = Usage(), time.perf_counter(), time.thread_time()
    assert usage.waiting(lambda: sum(range(1000))) == 499500
    assert 0 < usage.waited <= time.perf_counter() - start
    assert 0 <= usage.waited_cpu <= time.thread_time() - cpu


def test_an_error_in_rank_0s_own_thread_reaches_the_master(monkeypatch):
    def broken(*_):
        raise MemoryError("made up")

    monkeypatch.setattr("sweep.serve.worker.compute_rows", broken)
    own = OwnWorker(JOB)
    master = Master(None, Batches(np.arange(3), np.ones(3), 1), own, Memory().write, False)
    with pytest.raises(MemoryError, match="made up"):
        master.run(lambda: None)
    own.close()


def test_a_launcher_that_reads_late_has_passed_on_what_was_said_before_it_is_told_to_abort():
    passed, ended = [], []
    read, written = os.pipe()

    class Launched:
        Abort = staticmethod(lambda status: ended.append((status, passed.copy())))

    def pass_on():
        time.sleep(messages.FORWARDED / 4)
        passed.append(os.read(read, 100))

    launcher = threading.Thread(target=pass_on)
    os.write(written, b"sweep: a disk is full")
    launcher.start()
    messages.abort(Launched, 2)
    launcher.join()
    os.close(read), os.close(written)
    assert ended == [(2, [b"sweep: a disk is full"])]


def test_every_abort_waits_for_the_launcher():
    sources = Path(messages.__file__).parents[1].rglob("*.py")
    assert [path.name for path in sources if ".Abort(" in path.read_text(encoding="utf-8")] == ["messages.py"]
