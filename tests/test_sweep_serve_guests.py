"""A run and its guests: it gives them work, takes in their rows, and does what they leave."""

import contextlib
import errno
import fcntl
import os
import platform
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sweep.machine import compiled_for
from sweep.plan.batches import Batches
from sweep.serve import guests as served
from sweep.serve.grace import grace
from sweep.serve.guests import Guests, next_order
from sweep.serve.master import Master
from sweep.serve.worker import compute_rows
from sweep.store import lease, mailbox
from sweep.store.mailbox import GUEST, KIND, ORDER, ROWS, Sign

from .test_sweep_join import AXES, JOB, TASKS, folder

__all__ = ["folder"]  # a fixture


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
def run(tmp_path):
    """A run with nothing but guests: its batches, its guests and what was written."""
    batches = Batches(np.arange(TASKS), np.linspace(1.0, 2.0, TASKS), 1)
    found = Guests(tmp_path / "t.h5", JOB, batches, 3)
    memory = Memory()
    yield batches, found, Master(None, batches, None, memory.write, True, guests=found), memory
    found.close()


def orders_of(folder, name):
    """What lies there for this guest, by number."""
    found = [one.split(".") for one in mailbox.names(folder, ORDER)]
    return sorted(int(number) for who, number in found if who == name)


def answered(folder, name, number, count=None):
    """Compute an order as a guest does; only so many tasks of it where it is to stop."""
    order = mailbox.get(folder / f"{name}.{number}{ORDER}")
    ids = JOB.tasks.find({column: order[column] for column in AXES})[:count]
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


def test_what_a_guest_hands_back_that_is_to_stop_is_taken_in_and_the_rest_is_given_to_others(run, folder):
    batches, found, master, memory = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    first = found._guests[name].orders[0].ids
    assert len(first) > 1
    answered(folder, name, 0, 1)
    sign.close()
    master._serve_guests(found)
    assert memory.ids == first[:1].tolist()
    left = []
    while len(ids := batches.take()):
        left += ids.tolist()
    assert sorted([*memory.ids, *left]) == list(range(TASKS))
    assert (master.count.done, round(master.count.running, 9)) == (1, 0.0)
    assert not found.busy


def test_the_rows_of_an_order_may_come_in_parts(run, folder):
    _, found, master, memory = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    ids = found._guests[name].orders[0].ids
    order = mailbox.get(folder / f"{name}.0{ORDER}")
    for k in range(len(ids)):
        assert 0 in found._guests[name].orders
        mailbox.put(folder / f"{name}.0{ROWS}", compute_rows(JOB, ids[k : k + 1], int(order["rank"][0])))
        master._serve_guests(found)
        assert memory.ids == ids[: k + 1].tolist()
    assert 0 not in found._guests[name].orders
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


@pytest.mark.parametrize("others", [0, 1, 2])
def test_guests_on_another_kind_of_processor_are_told_of_and_named(run, folder, capsys, others):
    _, found, master, _ = run
    told, signs = [], []
    found._tell = lambda hosts, kinds: told.append((hosts, sorted(kinds)))
    kinds = [compiled_for(), *["older-1234abcd"] * others]
    for kind in kinds if others != 1 else kinds[1:]:
        ours = lease.new()
        (folder / f"{ours.token}.{KIND}").write_text(kind)
        signs.append(Sign(folder / f"{ours.token}{GUEST}", ours))
    master._serve_guests(found)
    whose = {1: "its rows", 2: "the rows of 2 of them"}.get(others)
    said = f"{whose} come of another kind of processor (older-1234abcd; here {compiled_for()})"
    assert (said in (err := capsys.readouterr().err)) == bool(others)
    assert ("kind of processor" in err) == bool(others)
    assert told == [([platform.node()] * len(signs), sorted(kinds if others != 1 else kinds[1:]))]
    for sign in signs:
        sign.close()


@pytest.mark.parametrize("harm", ["another task", "a changed number", "cut off", "no row"])
def test_rows_that_are_not_those_of_the_order_are_computed_again(run, folder, harm):
    batches, found, master, memory = run
    sign, name = arrived(folder)
    master._serve_guests(found)
    ids = JOB.tasks.find(_columns(folder, name))
    rows = compute_rows(JOB, (ids + (harm == "another task")) % TASKS, 3)
    if harm == "a changed number":
        rows["ke_ratio"][0] += 1.0
    place = folder / f"{name}.0{ROWS}"
    mailbox.put(place, rows[: len(rows) * (harm != "no row")])
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


def test_orders_shrink_towards_the_end_and_none_is_longer_or_larger_than_it_may_be():
    batches = Batches(np.arange(1000), np.full(1000, 0.5), 2)
    assert next_order(batches, 3.0).predicted <= 3.0
    sizes = []
    while len((order := next_order(batches, np.inf)).ids):
        assert order.predicted == pytest.approx(0.5 * len(order.ids))
        sizes.append(order.predicted)
    assert sizes[0] == pytest.approx(served.ORDER_SECONDS, abs=2.0)
    assert sizes[-1] <= 1.0
    many = 8 * served.ORDER_MAX
    tiny = Batches(np.arange(many), np.full(many, 1e-6), 1)
    assert len(next_order(tiny, np.inf).ids) <= served.ORDER_MAX


def test_near_a_deadline_an_order_throws_away_no_task_that_would_still_fit():
    batches = Batches(np.arange(100), np.full(100, 1.8), 1)
    orders = [next_order(batches, 3.0).ids.tolist() for _ in range(3)]
    assert orders == [[0], [1], [2]]
    assert (batches.skipped, batches.left) == (0, 97)
