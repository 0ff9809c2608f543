"""`sweep join`: processes come, go and die while a run goes on; the table has the same bits."""

import contextlib
import errno
import fcntl
import os
import platform
import signal
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from kernel.method import choose
from kernel.version import source_hash
from sweep import guest
from sweep.errors import InputError
from sweep.guest import join
from sweep.plan.batches import Batches
from sweep.plan.tasks import Tasks
from sweep.serve import guests as served
from sweep.serve.grace import grace
from sweep.serve.guests import Guests, next_order
from sweep.serve.master import Master
from sweep.serve.worker import Job, compute_rows
from sweep.store import lease, mailbox, reuse, table
from sweep.store.lock import only_run
from sweep.store.mailbox import GUEST, ORDER, ROWS, Sign, Watched
from sweep.store.runs import new_run
from sweep.store.writers import Waiting

from .waiting import wait_for

AXES = {"N": [5, 8], "zeta_T": [1e-3], "M_over_M0": [0.5, 2.0], "V_over_V0": [0.3, 1.0, 3.0]}
JOB = Job(Tasks(AXES), choose("auto", 1e-2), certify=False)
TASKS = 12


class Memory:
    """Takes the place of a table."""

    def __init__(self):
        self.ids = []

    def write(self, ids, rows):
        self.ids += ids.tolist()


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Looks without pauses."""
    for pause in ("LOOK_EVERY", "LIFE_EVERY"):
        monkeypatch.setattr(served, pause, 0.0)


@pytest.fixture
def long_spec(slow_spec):
    """A sweep of 252 tasks that takes half a minute, so that others have time to join."""
    slow_spec.write_text(slow_spec.read_text().replace("points = 41", "points = 21").replace("1e-7", "1e-11"))
    return slow_spec


@pytest.fixture
def folder(tmp_path):
    return mailbox.folder_of(tmp_path / "t.h5")


@pytest.fixture
def run(tmp_path):
    """A run with nothing but guests: its batches, its guests and what was written."""
    batches = Batches(np.arange(TASKS), np.linspace(1.0, 2.0, TASKS), 1)
    found = Guests(tmp_path / "t.h5", JOB, batches, 3)
    yield batches, found, Master(None, batches, None, memory := Memory(), True, guests=found), memory
    found.close()


def orders_of(folder, name):
    """What lies there for this guest, by number."""
    found = [one.split(".") for one in mailbox.names(folder, ORDER)]
    return sorted(int(number) for who, number in found if who == name)


def answered(folder, name, number):
    """Compute an order as a guest does."""
    order = mailbox.get(folder / f"{name}.{number}{ORDER}")
    ids = JOB.tasks.find({column: order[column] for column in AXES})
    mailbox.put(folder / f"{name}.{number}{ROWS}", compute_rows(JOB, ids, int(order["rank"][0])))


def arrived(folder, **changed):
    ours = replace(lease.new(), **changed)
    return Sign(folder / f"{ours.token}{GUEST}", ours), ours.token


def test_a_guest_is_given_work_ahead_and_its_rows_are_taken_in_once(run, folder):
    batches, found, master, memory = run
    sign, name = arrived(folder)
    number = 0
    while len(batches) or found.busy:
        master._serve_guests(found)
        assert len(orders_of(folder, name)) <= served.AHEAD
        if orders_of(folder, name):
            answered(folder, name, number)
            number += 1
    assert sorted(memory.ids) == list(range(TASKS))
    assert (master.count.done, round(master.count.running, 9)) == (TASKS, 0.0)
    sign.close()


def test_what_a_dead_guest_had_is_given_to_others_and_what_it_sends_later_is_thrown_away(run, folder):
    batches, found, master, memory = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    left = len(batches)
    assert left < TASKS
    late = mailbox.get(folder / f"{name}.0{ORDER}")
    fcntl.flock(sign._descriptor, fcntl.LOCK_UN)  # as the system does when a process is killed
    master._serve_guests(found)
    assert len(batches) == TASKS
    assert not orders_of(folder, name)
    mailbox.put(folder / f"{name}.0{ROWS}", compute_rows(JOB, np.arange(len(late)), 3))
    master._serve_guests(found)
    assert memory.ids == []
    assert not mailbox.names(folder, ROWS)
    sign.close()


def test_a_guest_of_another_node_is_dead_when_it_has_given_no_sign_for_long(run, folder, monkeypatch):
    batches, found, master, _ = run
    sign, _ = arrived(folder, host="elsewhere")
    master._serve_guests(found)
    fcntl.flock(sign._descriptor, fcntl.LOCK_UN)  # which other nodes do not see
    master._serve_guests(found)
    assert len(batches) < TASKS
    now = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now + lease.LEASE_MAX + 1)
    master._serve_guests(found)
    assert len(batches) == TASKS
    monkeypatch.undo()
    sign.close()


def test_many_that_join_at_once_are_told_of_in_one_line(run, folder, capsys):
    _, found, master, _ = run
    signs = [arrived(folder)[0] for _ in range(3)]
    master._serve_guests(found)
    assert f"3 processes on {platform.node()} have joined as ranks 3 to 5" in capsys.readouterr().err
    for sign in signs:
        sign.close()


@pytest.mark.parametrize("harm", ["another task", "a changed number", "cut off"])
def test_rows_that_are_not_those_of_the_order_are_computed_again(run, folder, harm):
    batches, found, master, memory = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    ids = JOB.tasks.find(_columns(folder, name))
    rows = compute_rows(JOB, (ids + (harm == "another task")) % TASKS, 3)
    if harm == "a changed number":
        rows["ke_ratio"][0] += 1.0
    place = folder / f"{name}.0{ROWS}"
    mailbox.put(place, rows)
    if harm == "cut off":
        place.write_bytes(place.read_bytes()[:-9])
    master._serve_guests(found)
    assert memory.ids == []
    assert len(batches) == TASKS
    assert not found.busy
    sign.close()


@contextlib.contextmanager
def a_disk_that_does_not_answer():
    """Whoever asks for a file gets the error of a Gluster disk without its server."""

    def refused(*_args, **_named):
        raise OSError(errno.ENOTCONN, os.strerror(errno.ENOTCONN))

    with pytest.MonkeyPatch.context() as patch:
        for place, name in ((Path, "iterdir"), (Path, "open"), (Path, "stat"), (Path, "unlink"), (np, "load")):
            patch.setattr(place, name, refused)
        yield


def test_a_disk_that_does_not_answer_for_a_while_costs_no_guest(run, folder):
    batches, found, master, memory = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    left = len(batches)
    answered(folder, name, 0)
    with a_disk_that_does_not_answer():
        master._serve_guests(found)
    assert (len(batches), memory.ids) == (left, [])
    master._serve_guests(found)
    assert memory.ids
    sign.close()


def test_what_cannot_be_given_to_a_guest_is_given_to_others(run, folder, monkeypatch, capsys):
    batches, found, master, _ = run
    sign, _ = arrived(folder)
    with monkeypatch.context() as patch:

        def full(*_args):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        patch.setattr(mailbox, "put", full)
        master._serve_guests(found)
    assert found.busy
    master._serve_guests(found)
    assert len(batches) == TASKS
    assert not found.busy
    assert "could not be given work (No space left on device)" in capsys.readouterr().err
    sign.close()


def test_an_order_that_a_disk_has_lost_is_given_to_others_in_time(run, folder, monkeypatch, capsys):
    batches, found, master, _ = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    (folder / f"{name}.0{ORDER}").unlink()
    now, allowed = time.monotonic(), grace(found._guests[name].orders[0].predicted)
    for late, busy in ((-1.0, True), (1.0, False)):
        monkeypatch.setattr(time, "monotonic", lambda late=late: now + allowed + late)
        alive = lease.read(sign._path)
        lease.write(sign._descriptor, replace(alive, beat=alive.beat + 1))
        master._serve_guests(found)
        assert (name in found._guests) == busy
    assert len(batches) == TASKS
    assert "has not answered in time; the" in capsys.readouterr().err
    monkeypatch.undo()
    sign.close()


class Slow:
    """Takes the place of the clock of a guest: no pause is slept."""

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


@pytest.fixture
def patience(folder, monkeypatch):
    monkeypatch.setattr(guest, "time", Slow())
    mailbox.empty(folder)
    run, ours = Sign(folder / mailbox.RUN), Sign(folder / f"one{GUEST}")
    yield guest.Patience(folder, "one", lambda: False, Waiting())
    for sign in (run, ours):
        sign.close()


def test_a_guest_tries_again_while_the_disk_does_not_answer(patience):
    tries = []

    def third_time():
        tries.append(None)
        if len(tries) < 3:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return len(tries)

    assert patience.until(third_time) == 3


def test_a_guest_that_was_taken_for_dead_knows_it(patience, folder):
    (folder / f"one{GUEST}").unlink()
    assert patience.until(lambda: None) is None
    assert patience.was_dismissed


def test_a_guest_whose_order_is_damaged_says_so_and_ends(tmp_path, capsys):
    folder, stopping = tmp_path, lambda: False
    columns = JOB.tasks.columns(np.arange(2))
    order = np.zeros(2, [*((name, values.dtype) for name, values in columns.items()), ("rank", "<i4")])
    for name, values in columns.items():
        order[name] = values
    mailbox.put(folder / f"one.0{ORDER}", order)
    (folder / f"one.1{ORDER}").write_bytes(b"no order")
    patience = guest.Patience(folder, "one", stopping, Waiting())
    assert guest._work(folder / "one", JOB, stopping, patience) == 2  # what it has sent before counts
    assert not patience.was_dismissed
    assert "one.1.order: damaged" in capsys.readouterr().err


def _columns(folder, name):
    order = mailbox.get(folder / f"{name}.0{ORDER}")
    return {column: order[column] for column in AXES}


def test_a_run_that_is_to_stop_takes_back_what_was_not_begun(run, folder):
    batches, found, master, _ = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    assert found.busy
    master._fits = lambda _: 0.0
    master.run(lambda: None)
    assert not found.busy
    assert batches.left == TASKS
    assert not orders_of(folder, name)
    sign.close()


def test_orders_shrink_towards_the_end_and_none_is_longer_than_what_fits():
    batches = Batches(np.arange(1000), np.full(1000, 0.5), 2)
    assert next_order(batches, 3.0).predicted <= 3.0
    sizes = []
    while len((order := next_order(batches, np.inf)).ids):
        assert order.predicted == pytest.approx(0.5 * len(order.ids))
        sizes.append(order.predicted)
    assert sizes[0] == pytest.approx(served.ORDER_SECONDS, abs=2.0)
    assert sizes[-1] <= 1.0


def test_near_a_deadline_an_order_throws_away_no_task_that_would_still_fit():
    batches = Batches(np.arange(100), np.full(100, 1.8), 1)
    orders = [next_order(batches, 3.0).ids.tolist() for _ in range(3)]
    assert orders == [[0], [1], [2]]
    assert (batches.skipped, batches.left) == (0, 97)


def test_a_table_without_a_run_cannot_be_joined(sweep, small_spec, tmp_path, monkeypatch):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    answer = sweep("join", "t.h5")
    assert answer.returncode == 2
    assert "no run of it is going on" in answer.stderr
    assert "Traceback" not in answer.stderr
    assert not mailbox.folder_of(tmp_path / "t.h5").exists()


def test_who_comes_while_a_run_compiles_is_told_to_come_again(sweep, small_spec, tmp_path):
    sweep("run", small_spec, "-o", "t.h5")
    with only_run(tmp_path / "t.h5"), pytest.raises(InputError, match=r"its run is still starting \(it may be comp"):
        join(None, tmp_path / "t.h5")


def test_the_kernel_of_the_run_that_goes_on_says_who_can_join(sweep, small_spec, tmp_path):
    """With --keep-rows earlier rows may be another kernel's; rows that were taken over always may."""
    path = tmp_path / "t.h5"
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    folder, now = mailbox.folder_of(path), source_hash()
    mailbox.empty(folder)
    run = Sign(folder / mailbox.RUN)
    for kernels, good in (((now,), True), (("old", now), True), ((now, "old"), False), (("old", now, ""), True)):
        with h5py.File(path, "r+") as file:
            file["runs"][: len(kernels)] = np.concatenate([new_run(0, 0.0, 1, 1, "gather", one) for one in kernels])
            file["runs"][len(kernels)] = reuse.entry(3, "elsewhere.h5", "auto", "older")
        refused = pytest.raises(InputError, match="is computed by another version")
        with contextlib.nullcontext() if good else refused:
            assert guest._job_of(path).certify
    run.close()


def test_guests_come_and_are_killed_and_the_table_has_the_same_bits(sweep, start, long_spec, tmp_path, physics):
    assert sweep("run", long_spec, "-o", "alone.h5").returncode == 0
    run = start("run", long_spec, "-o", "t.h5", ranks=2)
    folder = mailbox.folder_of(tmp_path / "t.h5")
    wait_for(lambda: (folder / mailbox.RUN).exists())
    killed, other = start("join", "t.h5"), start("join", "t.h5")
    wait_for(lambda: len({name.partition(".")[0] for name in mailbox.names(folder, ORDER)}) == 2)
    killed.send_signal(signal.SIGKILL)
    out, err = run.communicate(timeout=240)
    assert run.returncode == 0, err
    assert "252 done, 0 failed, 0 left" in out
    said, wrong = other.communicate(timeout=60)
    assert other.returncode == 0, wrong
    assert "252 done" in said
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "alone.h5")
    assert err.count("has joined as rank ") == 2 or "have joined as ranks 2 to 3" in err
    assert err.count("has ended or died; the") == 1
    assert not folder.exists()


def test_guests_end_when_the_run_is_killed_and_the_next_run_goes_on(sweep, start, long_spec, tmp_path, physics):
    run = start("run", long_spec, "-o", "t.h5")
    folder = mailbox.folder_of(tmp_path / "t.h5")
    wait_for(lambda: (folder / mailbox.RUN).exists())
    joined = start("join", "t.h5")
    wait_for(lambda: bool(mailbox.names(folder, GUEST)))
    run.send_signal(signal.SIGKILL)
    run.communicate(timeout=60)
    _, err = joined.communicate(timeout=120)
    assert joined.returncode == 75, err
    assert "the run has died" in err
    assert sweep("run", long_spec, "-o", "t.h5").returncode == 0
    assert not folder.exists()
    with table.reading(tmp_path / "t.h5") as file:
        assert table.counts(file) == (252, 0, 0)


def test_a_guest_that_was_taken_for_dead_joins_again(start, long_spec, tmp_path):
    run = start("run", long_spec, "-o", "t.h5")
    folder = mailbox.folder_of(tmp_path / "t.h5")
    wait_for(lambda: (folder / mailbox.RUN).exists())
    joined = start("join", "t.h5")
    wait_for(lambda: bool(mailbox.names(folder, ORDER)))  # the run has met it
    (folder / f"{mailbox.names(folder, GUEST)[0]}{GUEST}").unlink()
    out, err = joined.communicate(timeout=240)
    said, wrong = run.communicate(timeout=240)
    assert (joined.returncode, run.returncode) == (0, 0), err + wrong
    assert "it joins again" in err
    assert wrong.count("has joined as rank") == 2
    assert "252 done, 0 failed, 0 left" in out
    assert "252 done, 0 failed, 0 left" in said


def test_a_guest_that_is_to_stop_ends_and_its_work_is_done_by_the_run(start, long_spec, tmp_path):
    run = start("run", long_spec, "-o", "t.h5")
    folder = mailbox.folder_of(tmp_path / "t.h5")
    wait_for(lambda: (folder / mailbox.RUN).exists())
    joined = start("join", "t.h5")
    wait_for(lambda: bool(mailbox.names(folder, GUEST)))
    time.sleep(1.0)
    with contextlib.suppress(ProcessLookupError):
        os.kill(joined.pid, signal.SIGTERM)
    _, err = joined.communicate(timeout=120)
    out, wrong = run.communicate(timeout=240)
    assert (joined.returncode, run.returncode) == (75, 0), err + wrong
    assert "252 done, 0 failed, 0 left" in out


def test_a_sign_that_is_closed_or_missing_is_gone(tmp_path):
    sign = Sign(tmp_path / "run")
    watched = Watched(tmp_path / "run")
    assert not watched.is_gone()
    sign.close()
    assert watched.is_gone()


def test_what_is_no_table_cannot_be_joined(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        join(None, tmp_path / "none.h5")
