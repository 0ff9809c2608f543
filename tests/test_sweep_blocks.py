"""Rows in the blocks of a store: what was put in is found as it was, whoever else writes, dies, or damages it."""

import signal
import sqlite3
import subprocess
import sys
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.plan.tasks import Tasks
from sweep.schema import DONE, ROW, TOGETHER, blank_of, is_sealed, seal
from sweep.store import blocks
from sweep.store.blocks import keys_of
from sweep.store.shelf import FILE, Shelf

AXES = {"N": [5, 8, 9, 200], "zeta_T": [0.0, 1e-4, 1e-3], "M_over_M0": [0.5, 1.0, 2.0], "V_over_V0": [0.5, 1.0, 3.0]}
TASKS = Tasks(AXES)
SEEDS = st.integers(0, 2**32 - 1)


def made(rng: np.random.Generator, tasks: Tasks = TASKS) -> np.ndarray:
    """A done row of every task, with numbers drawn at random."""
    rows = blank_of(tasks.columns(np.arange(len(tasks))), ROW)
    rows["status"], rows["ke_ratio"] = DONE, rng.random(len(tasks))
    seal(rows)
    return rows


@pytest.fixture
def small_blocks(monkeypatch):
    """Of five rows."""
    monkeypatch.setattr(blocks, "BLOCK", 5 * ROW.itemsize)


def held(folder) -> list[int]:
    """How many rows each block has."""
    with sqlite3.connect(folder / FILE) as file:
        return [size // blocks.INDEX.itemsize for (size,) in file.execute("SELECT length(entries) FROM blocks")]


@given(SEEDS, st.integers(1, 40), st.integers(1, 4))
def test_what_was_put_in_is_found_as_it_was_and_nothing_else(tmp_path_factory, seed, in_a_block, times):
    rng = np.random.default_rng(seed)
    store = Shelf(tmp_path_factory.mktemp("store"))
    kind, origins = store.kind("ours"), [store.origin(f"place {k}") for k in range(times)]
    known = dict[int, tuple[bytes, int]]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "BLOCK", in_a_block * ROW.itemsize)
        for origin in origins:  # what is put in again takes the place of what was there
            put, rows = rng.choice(len(TASKS), rng.integers(0, len(TASKS)), replace=False), made(rng)
            store.put(kind, origin, rows[put])
            known |= {task: (rows[task].tobytes(), origin) for task in put.tolist()}
    asked = rng.choice(len(TASKS), rng.integers(1, 2 * len(TASKS)))  # the same task twice, too
    taken = store.find(kind, TASKS.columns(asked), ROW)
    assert sorted(taken.where) == [k for k, task in enumerate(asked.tolist()) if task in known]
    for where, row, origin in zip(*taken, strict=True):
        assert (row.tobytes(), origin) == known[asked[where]]
    assert not len(store.find(store.kind("others"), TASKS.columns(asked), ROW).where)
    store.close()
    assert max(held(store.path.parent)) <= in_a_block


def test_of_two_rows_of_one_task_that_come_together_the_later_is_kept(tmp_path):
    store, rows = Shelf(tmp_path), made(np.random.default_rng(1))
    again = made(np.random.default_rng(2))
    store.put(store.kind("ours"), 1, np.concatenate([rows, again]))
    taken = store.find(store.kind("ours"), TASKS.columns(np.arange(len(TASKS))), ROW)
    assert taken.rows[np.argsort(taken.where)].tobytes() == again.tobytes()
    store.close()


def test_writers_of_the_same_blocks_at_once_lose_no_row_of_each_other(tmp_path, small_blocks):
    rows, wrong = made(np.random.default_rng(1)), list[Exception]()
    Shelf(tmp_path).close()

    def write(which):
        store = Shelf(tmp_path)
        kind, origin = store.kind("ours"), store.origin(f"writer {which}")
        for k in range(which, len(rows), 4):  # neighbours are of different writers
            try:
                store.put(kind, origin, rows[k : k + 1])
            except Exception as error:
                wrong.append(error)
        store.close()

    threads = [threading.Thread(target=write, args=(which,)) for which in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
    store = Shelf(tmp_path)
    taken = store.find(store.kind("ours"), TASKS.columns(np.arange(len(TASKS))), ROW)
    assert taken.rows[np.argsort(taken.where)].tobytes() == rows.tobytes()
    for which in range(4):
        assert set(taken.where[taken.origins == store.origin(f"writer {which}")] % 4) == {which}
    store.close()


def test_a_reader_finds_all_that_was_there_while_a_writer_splits_the_blocks(tmp_path, small_blocks, monkeypatch):
    monkeypatch.setattr("sweep.store.shelf.AT_ONCE", 1)
    rng = np.random.default_rng(1)
    rows, store = made(rng), Shelf(tmp_path)
    kind, before = store.kind("ours"), rng.choice(len(rows), len(rows) // 4, replace=False)
    others = np.setdiff1d(np.arange(len(rows)), before)
    store.put(kind, 1, rows[before])
    writer, reads = Shelf(tmp_path), store._below

    def below(*asked):  # after every reading, another writes
        answer = reads(*asked)
        store._file.execute("COMMIT")
        writer.put(kind, 2, rows[np.concatenate([rng.choice(others, 9), rng.choice(before, 1)])])
        store._file.execute("BEGIN")
        return answer

    monkeypatch.setattr(store, "_below", below)
    taken = store.find(kind, TASKS.columns(before), ROW)
    assert sorted(taken.where) == list(range(len(before)))
    for where, row in zip(taken.where, taken.rows, strict=True):
        assert row.tobytes() == rows[before[where]].tobytes()
    for one in (store, writer):
        one.close()


KILLED = """
import os, signal, sys
import numpy as np
from pathlib import Path
from sweep.store import blocks, shelf
rows = np.load(sys.argv[2])
blocks.BLOCK = 5 * rows.dtype.itemsize
store, split = shelf.Shelf(Path(sys.argv[1])), shelf.records_of
def records_of(*asked):
    for k, record in enumerate(split(*asked)):
        yield record
        if k == 3:
            os.kill(os.getpid(), signal.SIGKILL)
shelf.records_of = records_of
store._file.execute("PRAGMA cache_size = 1")  # so that the file is written to before the end
store.put(store.kind("ours"), 2, rows)
"""


@pytest.mark.slow
def test_a_writer_that_is_killed_leaves_what_was_there(tmp_path, small_blocks):
    rng, store = np.random.default_rng(1), Shelf(tmp_path)
    rows, kind = made(rng), store.kind("ours")
    store.put(kind, 1, rows[::3])
    np.save(tmp_path / "new.npy", made(rng))
    words = [sys.executable, "-P", "-c", KILLED, tmp_path, tmp_path / "new.npy"]
    assert subprocess.run(words, timeout=240, check=False).returncode == -signal.SIGKILL
    assert (tmp_path / f"{FILE}-journal").exists()
    taken = store.find(kind, TASKS.columns(np.arange(len(TASKS))), ROW)
    assert taken.rows[np.argsort(taken.where)].tobytes() == rows[::3].tobytes()
    store.close()


def test_what_fails_while_rows_are_put_in_leaves_what_was_there(tmp_path, small_blocks, monkeypatch):
    rng, store = np.random.default_rng(1), Shelf(tmp_path)
    rows, kind = made(rng), store.kind("ours")
    store.put(kind, 1, rows[::3])
    with monkeypatch.context() as patch:
        patch.setattr("sweep.store.shelf.AT_ONCE", 2)
        reads, count = store._below, iter(range(3))
        patch.setattr(store, "_below", lambda *asked: reads(*asked) if next(count) < 2 else 1 / 0)
        with pytest.raises(ZeroDivisionError):
            store.put(kind, 2, made(rng))
    taken = store.find(kind, TASKS.columns(np.arange(len(TASKS))), ROW)
    assert taken.rows[np.argsort(taken.where)].tobytes() == rows[::3].tobytes()
    store.close()


@given(SEEDS, st.integers(1, 3 * TOGETHER), st.integers(0, 4))
def test_the_rows_that_are_damaged_are_told_and_no_others(seed, count, damaged):
    rng = np.random.default_rng(seed)
    rows = np.frombuffer(rng.bytes(count * ROW.itemsize), ROW).copy()
    seal(rows)
    which = np.unique(rng.integers(0, count, damaged))
    raw, bit = rows.view(np.uint8).reshape(count, -1), np.uint8(1 << rng.integers(0, 8))
    raw[which, rng.integers(0, ROW.itemsize, len(which))] ^= bit
    assert np.flatnonzero(~is_sealed(rows)).tolist() == which.tolist()


def test_tasks_of_a_large_grid_have_keys_of_their_own():
    axes = {"N": list(range(2, 22)), "zeta_T": np.geomspace(1e-5, 1, 20), "M_over_M0": np.geomspace(0.1, 10, 30)}
    tasks = Tasks(axes | {"V_over_V0": np.geomspace(0.1, 10, 30)})
    keys = keys_of(7, tasks.columns(np.arange(len(tasks))))
    assert len(np.unique(keys)) == len(tasks) == 360_000
    assert keys.min() >= 0
    assert keys.max() > 2**62  # of the whole range, as few as may be the same
    assert not np.isin(keys_of(8, tasks.columns(np.arange(len(tasks)))), keys).any()
