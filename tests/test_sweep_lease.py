"""Across nodes a lease tells who writes a table, where locks do not reach, or outlive their node."""

import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from sweep.errors import InputError
from sweep.store import lease, lock
from sweep.store.lease import Lease
from sweep.store.lock import only_run


@pytest.fixture
def quick(monkeypatch):
    """Everything a hundred times as fast."""
    for module, name, seconds in ((lease, "BEAT", 0.05), (lease, "SETTLE", 0.03), (lock, "LOOK_EVERY", 0.01)):
        monkeypatch.setattr(module, name, seconds)
    monkeypatch.setattr(lock, "LEASE_MAX", 0.75)


def of_another_node(path: Path) -> Lease:
    """As a run on another node leaves it, on a disk where its lock cannot be seen from here."""
    theirs = replace(lease.new(), host="node7", process=12)
    with path.open("w+b") as file:
        lease.write(file.fileno(), theirs)
    return theirs


def test_a_living_run_on_another_node_is_respected_without_its_lock(quick, tmp_path):
    path, ending = tmp_path / ".t.h5.lock", threading.Event()
    theirs = of_another_node(path)

    def live() -> None:
        with path.open("r+b") as file:
            beat = 0
            while not ending.wait(0.05):
                beat += 1
                lease.write(file.fileno(), replace(theirs, beat=beat))

    living = threading.Thread(target=live)
    living.start()
    try:
        with (
            pytest.raises(InputError, match=r"a run on node7 \(process 12\) is writing this table"),
            only_run(tmp_path / "t.h5"),
        ):
            pass
    finally:
        ending.set()
        living.join()


def test_a_dead_nodes_lease_is_waited_for_and_taken_over(quick, tmp_path, capsys):
    theirs = of_another_node(tmp_path / ".t.h5.lock")
    began = time.monotonic()
    with only_run(tmp_path / "t.h5"):
        assert time.monotonic() - began > lock.LEASE_MAX
        ours = lease.read(tmp_path / ".t.h5.lock")
        assert ours is not None
        assert not ours.is_of(theirs)
    assert "a run on node7 holds this table; waiting up to " in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_died_on_this_node_is_not_waited_for(tmp_path):
    with (tmp_path / ".t.h5.lock").open("w+b") as file:
        lease.write(file.fileno(), lease.new())
    with only_run(tmp_path / "t.h5"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_of_two_nodes_without_common_locks_that_start_at_once_one_gets_the_table(quick, tmp_path, monkeypatch):
    monkeypatch.setattr(lock.fcntl, "flock", lambda *_: None)
    monkeypatch.setattr(lease.disk, "is_shared", lambda _: True)
    names = threading.local()
    monkeypatch.setattr(lease.platform, "node", lambda: names.name)
    holders, ends, start = [], [], threading.Barrier(2)

    def node(name: str) -> None:
        names.name = name
        start.wait()
        try:
            with only_run(tmp_path / "t.h5"):
                holders.append(name)
                assert len(holders) == 1
                time.sleep(1.0)
                holders.remove(name)
            ends.append("wrote")
        except InputError:
            ends.append("refused")

    nodes = [threading.Thread(target=node, args=(f"node{i}",)) for i in (1, 2)]
    for each in nodes:
        each.start()
    for each in nodes:
        each.join(60)
    assert sorted(ends) == ["refused", "wrote"]


def test_a_holder_that_cannot_renew_its_lease_stops_before_others_may_begin():
    assert lease.HOLD_MAX + 2 * lease.BEAT < lease.LEASE_MAX  # a sign of life may just have been missed at either end


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("writes", [True, False])
def test_a_holder_that_was_silent_for_too_long_stops_where_others_may_have_begun(tmp_path, monkeypatch, shared, writes):
    """A disk that was gone, or a process that was held still, which may write again by now."""
    ours, told, clock = lease.new(), [], [1000.0]
    monkeypatch.setattr(lease.disk, "is_shared", lambda _: shared)
    monkeypatch.setattr(lease.time, "monotonic", lambda: clock[0])
    with (tmp_path / ".t.h5.lock").open("w+b") as file:
        lease.write(file.fileno(), ours)
        keeper = lease.Keeper(tmp_path / ".t.h5.lock", file.fileno() if writes else -1, ours, told.append)
        for passed, lost in ((0.5, False), (0.9, False), (1.01, shared)):
            clock[0] = (clock[0] if writes else 1000.0) + passed * lease.HOLD_MAX
            keeper._beat()
            assert bool(told) == lost
        keeper.close()
    assert not told or "could not be renewed" in told[0]


def test_a_dead_nodes_lock_that_its_disk_does_not_let_go_of_is_told(quick, tmp_path, monkeypatch):
    def held(*_):
        raise BlockingIOError

    of_another_node(tmp_path / ".t.h5.lock")
    monkeypatch.setattr(lock.fcntl, "flock", held)
    monkeypatch.setattr(lock, "LEASE_MAX", 0.1)
    with (
        pytest.raises(InputError, match="is dead, but its file system still holds its lock"),
        only_run(tmp_path / "t.h5"),
    ):
        pass


def test_who_was_taken_for_dead_and_is_not_learns_it(quick, tmp_path):
    told, known = [], threading.Event()

    def lost(why: str) -> None:
        told.append(why)
        known.set()

    with only_run(tmp_path / "t.h5", lost):
        of_another_node(tmp_path / ".t.h5.lock")
        assert known.wait(30)
    assert told[0] == "a run on node7 (process 12) has taken the table over"
    assert (tmp_path / ".t.h5.lock").exists()  # theirs
