"""`sweep join`: processes come, go and die while a run goes on; the table has the same bits."""

import contextlib
import errno
import os
import signal
import time

import h5py
import numpy as np
import pytest

from kernel.method import choose
from kernel.version import source_hash
from sweep import guest
from sweep.errors import InputError
from sweep.guest import join
from sweep.plan.tasks import Tasks
from sweep.schema import is_ended
from sweep.serve.worker import Job, compute_rows
from sweep.store import mailbox, reuse, table
from sweep.store.lock import only_run
from sweep.store.mailbox import GUEST, ORDER, ROWS, Sign, Watched
from sweep.store.runs import new_run
from sweep.store.writers import Waiting

from .waiting import wait_for

AXES = {"N": [5, 8], "zeta_T": [1e-3], "M_over_M0": [0.5, 2.0], "V_over_V0": [0.3, 1.0, 3.0]}
JOB = Job(Tasks(AXES), choose("auto", 1e-2), certify=False)
TASKS = 12


@pytest.fixture
def long_spec(slow_spec):
    """A sweep of 252 tasks that takes half a minute, so that others have time to join."""
    slow_spec.write_text(slow_spec.read_text().replace("points = 41", "points = 21").replace("1e-7", "1e-11"))
    return slow_spec


@pytest.fixture
def folder(tmp_path):
    return mailbox.folder_of(tmp_path / "t.h5")


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


@pytest.fixture
def ordered(patience, folder, monkeypatch):
    """ordered(count): gives the guest an order of so many tasks; what it then computes, task by task."""
    computed = []

    def one_more(job, ids, rank):
        computed.append(len(ids))
        return compute_rows(job, ids, rank)

    def give(count):
        columns = JOB.tasks.columns(np.arange(count))
        order = np.zeros(count, [*((name, values.dtype) for name, values in columns.items()), ("rank", "<i4")])
        for name, values in columns.items():
            order[name] = values
        mailbox.put(folder / f"one.0{ORDER}", order)
        return computed

    monkeypatch.setattr(guest, "compute_rows", one_more)
    monkeypatch.setattr(guest, "PIECE_SECONDS", 0.0)
    return give


def test_a_guest_whose_order_is_damaged_says_so_and_ends(ordered, folder, patience, capsys):
    ordered(2)
    (folder / f"one.1{ORDER}").write_bytes(b"no order")
    assert guest._work(folder / "one", JOB, lambda: False, patience) == 2  # what it has sent before counts
    assert not patience.was_dismissed
    assert "one.1.order: damaged" in capsys.readouterr().err


def test_a_guest_that_is_to_stop_hands_back_what_it_has_computed_of_its_order(ordered, folder, patience):
    computed = ordered(TASKS)
    patience._stopping = lambda: len(computed) == 3
    assert guest._work(folder / "one", JOB, patience._stopping, patience) == 3
    assert computed == [1, 1, 1]
    rows = mailbox.get(folder / f"one.0{ROWS}")
    assert JOB.tasks.find({name: rows[name] for name in AXES}).tolist() == [0, 1, 2]
    assert is_ended(rows).all()


def test_what_came_of_an_order_is_sent_in_parts_each_once_the_run_has_taken_the_one_before(
    ordered, folder, patience, monkeypatch
):
    ordered(TASKS)
    sent, pauses, clock = [], [], guest.time
    place = folder / f"one.0{ROWS}"
    monkeypatch.setattr(guest, "PART_SECONDS", 0.0)

    def take_seldom(seconds):
        pauses.append(seconds)
        if len(pauses) % 3 == 0 and place.exists():
            sent.append(mailbox.get(place))

    clock.sleep = take_seldom
    patience._stopping = lambda: sum(map(len, sent)) == TASKS
    assert guest._work(folder / "one", JOB, patience._stopping, patience) == TASKS
    assert [len(rows) for rows in sent] == [1] * TASKS
    rows = np.concatenate(sent)
    assert JOB.tasks.find({name: rows[name] for name in AXES}).tolist() == list(range(TASKS))


@pytest.mark.parametrize("dismissed", [True, False])
def test_a_guest_that_nobody_waits_for_computes_its_order_no_further(ordered, folder, patience, monkeypatch, dismissed):
    computed = ordered(TASKS)
    clock = guest.time

    def later():
        if len(computed) == 2:
            (folder / (f"one{GUEST}" if dismissed else mailbox.RUN)).unlink(missing_ok=True)
            clock.now += guest.LIFE_EVERY
        return False

    patience._stopping = later
    assert guest._work(folder / "one", JOB, lambda: False, patience) == 0
    assert len(computed) == 2
    assert patience.was_dismissed == dismissed
    assert not mailbox.names(folder, ROWS)


def test_pieces_of_an_order_become_as_long_as_they_may(monkeypatch):
    pieces, sizes = guest.Pieces(), []
    for _ in range(12):
        sizes.append(pieces.tasks)
        pieces.took(pieces.tasks * guest.PIECE_SECONDS / 100)
    assert sizes == [1, 2, 4, 8, 16, 32, 64, 100, 100, 100, 100, 100]
    pieces.took(1000 * guest.PIECE_SECONDS)
    assert pieces.tasks == 1


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
            file["runs"][: len(kernels)] = np.concatenate([new_run(0, "gather", one) for one in kernels])
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


def test_a_guest_that_writes_while_the_run_ends_leaves_nothing_behind(tmp_path, monkeypatch):
    folder, remove = tmp_path / ".t.h5.join", os.rmdir
    mailbox.empty(folder)

    def removed_late(*where, **how):
        with contextlib.suppress(FileNotFoundError):
            (folder / "guest.0.rows.partial").touch()
        remove(*where, **how)

    monkeypatch.setattr(os, "rmdir", removed_late)
    mailbox.remove(folder)
    assert not list(tmp_path.iterdir())


def test_a_sign_that_is_closed_or_missing_is_gone(tmp_path):
    sign = Sign(tmp_path / "run")
    watched = Watched(tmp_path / "run")
    assert not watched.is_gone()
    sign.close()
    assert watched.is_gone()


def test_what_is_no_table_cannot_be_joined(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        join(None, tmp_path / "none.h5")
