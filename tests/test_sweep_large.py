"""Large sweeps: batches are made part by part, rows that nobody wrote are read as pending, and all else is the same."""

import tracemalloc

import h5py
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import analysis
from analysis import reading, streamed
from analysis.cli import main
from sweep.errors import DamagedTableError
from sweep.plan import batches, parts, shard
from sweep.plan.batches import Batches, batches_of
from sweep.plan.parts import Parts
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, PENDING, ROW, blank_of, seal
from sweep.store import table, unwritten

from .conftest import rows_of

AXES = {"N": [5, 8, 13], "zeta_T": [0.0, 1e-3], "M_over_M0": [0.5, 2.0], "V_over_V0": [0.3, 1.0, 3.0]}
TASKS = Tasks(AXES)
KNOWN = {
    "resolved": '{"grid": {"N": [5, 8, 13], "zeta_T": [0.0, 1e-3], "M_over_M0": [0.5, 2], "V_over_V0": [0.3, 1, 3]}}'
}
FEW = 7  # tasks of a part here


@pytest.fixture(autouse=True)
def small_is_large():
    """What holds of millions of rows holds here of a few."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (parts, batches, shard):
            patch.setattr(module, "PART", FEW)
        for module in (unwritten, reading):
            patch.setattr(module, "ROWS_WRITTEN_MAX", 1)
        patch.setattr(unwritten, "PROBES", 4)
        patch.setattr(streamed, "ROWS_MAX", 1)
        patch.setattr(table, "ROWS_AT_ONCE", FEW)
        yield


def done_rows(ids: np.ndarray, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    rows = blank_of(TASKS.columns(ids))
    rows["status"], rows["checked"], rows["rank"], rows["method"] = DONE, True, 0, b"explicit"
    rows["ke_ratio"], rows["error"], rows["chaotic"] = rng.random(len(ids)), 1e-4, rng.random(len(ids)) < 0.4
    seal(rows)
    return rows


def write(path, ids, rows) -> None:
    with h5py.File(path, "r+") as file:
        table.write_rows(file["results"], ids, rows)


LEFT = st.lists(st.booleans(), min_size=FEW + 1, max_size=60).map(np.array)


@given(LEFT, st.integers(1, 300), st.randoms(use_true_random=False))
def test_part_by_part_every_task_that_is_left_goes_out_exactly_once(left, ranks, random):
    seconds = np.array([random.uniform(1e-3, 3.0) for _ in left])
    some, taken = batches_of(left, lambda ids: seconds[ids], ranks), []
    assert len(some) == some.left == np.count_nonzero(left)
    while len(ids := some.take()):
        assert abs(some.taken - seconds[ids].sum()) < 1e-9
        taken.append(ids)
    assert sorted(np.concatenate([[], *taken]).tolist()) == np.flatnonzero(left).tolist()
    assert len(some) == 0
    assert some.seconds_left == 0


@given(LEFT, st.floats(0.0, 3.0), st.randoms(use_true_random=False))
def test_part_by_part_what_does_not_fit_stays_and_is_counted(left, fits, random):
    seconds = np.array([random.uniform(1e-3, 3.0) for _ in left])
    some, taken = batches_of(left, lambda ids: seconds[ids], 2), []
    while len(ids := some.take(fits)):
        taken += ids.tolist()
    assert sorted(taken) == np.flatnonzero(left & (seconds <= fits)).tolist()
    assert some.left == np.count_nonzero(left) - len(taken)


def test_the_parts_with_the_longest_tasks_come_first_and_end_with_their_shortest():
    seconds = np.arange(3.0 * FEW) % FEW + np.repeat([1.0, 30.0, 10.0], FEW)
    some, order = batches_of(np.ones(3 * FEW, bool), lambda ids: seconds[ids], 1), []
    while len(ids := some.take()):
        order += ids.tolist()
    assert [k // FEW for k in order] == [1] * FEW + [2] * FEW + [0] * FEW
    assert all(np.all(np.diff(seconds[order[k : k + FEW]]) < 0) for k in range(0, 3 * FEW, FEW))


def test_a_run_that_stops_predicts_no_part_that_it_does_not_need(monkeypatch):
    monkeypatch.setattr(parts, "SAMPLE", 1)
    asked = []

    def predict(ids):
        asked.append(len(ids))
        return np.full(len(ids), 1.0)

    some = Batches(batches.NO_TASKS, batches.NO_SECONDS, 1, Parts(np.ones(100 * FEW, bool), predict))
    assert asked == [1] * 100
    some.take()
    some.take(0.0)
    assert sum(asked[100:]) <= 2 * FEW  # the part under way, and the one after it
    assert some.left == 100 * FEW - 2  # a batch of two seconds


def test_what_batches_hold_does_not_grow_with_the_sweep_but_by_a_byte_a_task(monkeypatch):
    for module in (parts, batches):
        monkeypatch.setattr(module, "PART", 1 << 16)

    def peak(tasks: int) -> int:
        tracemalloc.start()
        some = batches_of(np.ones(tasks, bool), lambda ids: np.full(len(ids), 1e-3), 4)
        while len(some) > tasks - 3 * (1 << 16):
            some.take()
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most

    small, large = peak(1 << 20), peak(1 << 23)
    assert large - small < 1.3 * ((1 << 23) - (1 << 20))


@given(st.lists(st.integers(0, len(TASKS) - 1), unique=True, min_size=1, max_size=20))
def test_unwritten_rows_read_as_those_of_a_table_written_whole(tmp_path_factory, ids):
    folder, ids = tmp_path_factory.mktemp("large"), np.array(ids, np.int64)
    told = []
    for name, known in (("sparse", KNOWN), ("whole", {})):
        path = folder / f"{name}.h5"
        table.create(path, TASKS, known)
        write(path, ids, done_rows(ids))
        with table.reading(path) as file:
            rows = np.concatenate([some for _, some in table.chunks(file)])
            written = [some for some in table.finished_rows(file) if len(some)]
            told.append(
                (
                    rows.tobytes(),
                    table.finished(file).tolist(),
                    table.counts(file),
                    np.concatenate([rows[:0], *written]).tobytes(),
                )
            )
    assert told[0] == told[1]
    frames = [analysis.load(folder / f"{name}.h5", done_only=False) for name in ("sparse", "whole")]
    assert frames[0].equals(frames[1])


def test_a_table_whose_rows_were_all_computed_has_the_bits_of_one_that_was_written_whole(tmp_path):
    bits = []
    for name, known in (("sparse", KNOWN), ("whole", {})):
        path = tmp_path / f"{name}.h5"
        table.create(path, TASKS, known)
        write(path, np.arange(len(TASKS)), done_rows(np.arange(len(TASKS))))
        with h5py.File(path) as file:
            bits.append(file["results"][()].tobytes())
    assert bits[0] == bits[1]


def test_a_new_table_writes_few_rows(tmp_path):
    table.create(tmp_path / "t.h5", TASKS, KNOWN)
    rows = rows_of(tmp_path / "t.h5")
    assert np.count_nonzero(rows["status"] == PENDING) == 4
    assert not rows[1].tobytes().strip(b"\0")


def test_what_is_read_past_holes_is_what_is_there(tmp_path):
    """Of a file large enough that the file system keeps holes."""
    grid = Tasks({**AXES, "zeta_T": np.linspace(0, 1e-2, 20_000).tolist()})
    path = tmp_path / "t.h5"
    table.create(path, TASKS, KNOWN)
    with h5py.File(path, "r") as file:
        start = file["results"].id.get_offset()
    with path.open("r+b") as raw:
        raw.truncate(start + len(grid) * ROW.itemsize)
        raw.seek(start + 150_000 * ROW.itemsize)
        raw.write(b"x" * 3 * ROW.itemsize)

    class Large:
        filename = str(path)

        def __getitem__(self, _):
            return self

        def __len__(self):
            return len(grid)

    large = Large()
    large.dtype, large.size, large.id = ROW, len(grid), type("", (), {"get_offset": lambda _: start})()
    with unwritten.Sparse(large) as sparse:
        assert sparse.read(slice(100_000, 110_000)) is None
        rows = sparse.read(slice(149_000, 151_000))
        assert np.flatnonzero(rows["N"]).tolist() == [1000, 1001, 1002]
        assert rows[1000].tobytes() == b"x" * ROW.itemsize


def test_a_table_that_is_cut_off_is_damaged(tmp_path):
    table.create(tmp_path / "t.h5", TASKS, KNOWN)
    with table.reading(tmp_path / "t.h5") as file, (tmp_path / "t.h5").open("r+b") as raw:
        raw.truncate(file["results"].id.get_offset() + 5 * ROW.itemsize)
        with pytest.raises(DamagedTableError, match="is damaged"):
            table.finished(file)


def test_rows_may_be_unwritten_in_a_large_grid_only_and_in_no_shard(monkeypatch):
    assert len(unwritten.grid_of(KNOWN, len(TASKS))) == len(TASKS)
    assert unwritten.grid_of(KNOWN | {"shard": "1/1"}, len(TASKS)) is None
    monkeypatch.setattr(unwritten, "ROWS_WRITTEN_MAX", len(TASKS))
    assert unwritten.grid_of(KNOWN, len(TASKS)) is None


@given(st.integers(1, len(TASKS)), st.randoms(use_true_random=False))
def test_of_a_large_sweep_too_every_task_is_in_exactly_one_shard(count, random):
    work = np.array([1.0 - random.random() for _ in range(len(TASKS))])
    shards = [shard.share(TASKS, lambda ids: work[ids], shard.Shard(k, count)) for k in range(1, count + 1)]
    found = [TASKS.find(one.columns(np.arange(len(one)))) for one in shards if len(one)]
    assert sorted(np.concatenate(found).tolist()) == list(range(len(TASKS)))


@pytest.mark.slow
@given(ids=st.lists(st.integers(0, len(TASKS) - 1), unique=True, min_size=1), seed=st.integers(0, 9), too=st.booleans())
def test_the_best_of_a_table_read_part_by_part_is_that_of_the_whole(tmp_path_factory, ids, seed, too):
    path, ids = tmp_path_factory.mktemp("best") / "t.h5", np.array(sorted(ids))
    table.create(path, TASKS, KNOWN)
    write(path, ids, done_rows(ids, seed))
    found = streamed.best_of_grid(str(path), TASKS, too)
    df = analysis.load(path)
    assert found.cells.equals(analysis.best(df, chaotic_too=too))
    used = len(analysis.best.__globals__["competing"](df, chaotic_too=too))
    assert found.lines[1].startswith(f"used      {used} finished rows; left out: 0 without")
    assert f"{len(df)} done, {len(TASKS) - len(df)} pending" in found.lines[0]


@pytest.mark.slow
def test_the_command_draws_the_best_of_a_large_table(tmp_path, capsys, monkeypatch):
    table.create(tmp_path / "t.h5", TASKS, KNOWN)
    write(tmp_path / "t.h5", np.arange(30), done_rows(np.arange(30)))
    printed = []
    for most in (1, 1000):
        monkeypatch.setattr(streamed, "ROWS_MAX", most)
        assert main(["best", str(tmp_path / "t.h5"), "-o", str(tmp_path / "b.png"), "--force"]) == 0
        printed.append((capsys.readouterr().out.splitlines(), (tmp_path / "b.best.csv").read_text()))
    (few, small), (every, large) = printed
    assert small == large
    assert set(few[1:3]) <= set(every)


def test_the_best_of_a_large_table_says_what_of_its_chain_is_not_the_papers(tmp_path):
    table.create(tmp_path / "t.h5", TASKS, {"resolved": '{"model": {"wall": "free"}}'})
    write(tmp_path / "t.h5", np.arange(30), done_rows(np.arange(30)))
    said = streamed.best_of_grid(str(tmp_path / "t.h5"), TASKS, chaotic_too=True).notes.said
    assert said == "6 of 36 rows are yet to be computed. The far end is free."


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ["best", "--at", "N=8"],
        ["best", "--over", "N,M_over_M0", "--at", "zeta_T=1e-3"],
        ["map", "--at", "M_over_M0=2", "V_over_V0=1"],
        ["points", "--at", "M_over_M0=2"],
        ["level", "--level", "0.5", "--along", "V_over_V0", "--at", "N=5"],
    ],
)
def test_a_picture_of_some_rows_of_a_large_table_is_that_of_the_whole(tmp_path, capsys, monkeypatch, command):
    name, *options = command
    table.create(tmp_path / "t.h5", TASKS, KNOWN)
    write(tmp_path / "t.h5", np.arange(30), done_rows(np.arange(30)))
    told = []
    for most in (24, 1000):
        monkeypatch.setattr(streamed, "ROWS_MAX", most)
        assert main([name, str(tmp_path / "t.h5"), "-o", str(tmp_path / "p.png"), "--force", *options]) == 0
        numbers = next(tmp_path.glob("p.*.csv")).read_text()
        lines = capsys.readouterr().out.splitlines()
        told.append(([line for line in lines if line[:5] != "rows "], numbers, (tmp_path / "p.png").read_bytes()))
    assert told[0] == told[1]


@given(ids=st.lists(st.integers(0, len(TASKS) - 1), unique=True, min_size=1), zeta_T=st.sampled_from([0.0, 1e-3]))
def test_the_rows_of_a_large_table_with_some_value_are_those_of_the_whole(tmp_path_factory, ids, zeta_T):
    path, ids = tmp_path_factory.mktemp("some") / "t.h5", np.array(sorted(ids), np.int64)
    table.create(path, TASKS, KNOWN)
    write(path, ids, done_rows(ids))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(streamed, "ROWS_MAX", len(TASKS))
        some = streamed.rows_at(path, TASKS, {"zeta_T": zeta_T, "N": 8})
    whole = analysis.load(path, done_only=False)
    pd.testing.assert_frame_equal(some, whole[(whole["zeta_T"] == zeta_T) & (whole["N"] == 8)], check_categorical=False)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ["--at", "M_over_M0=2"],
            "18 of its 36 rows are more than the 1 that are read at once: fix parameters by --at",
        ),
        (["--at", "M_over_M0=3"], "no task has M_over_M0 = 3; there is 0.5, 2"),
        ([], "its 36 rows are more than the 1 that are read at once"),
    ],
)
def test_what_cannot_be_read_at_once_is_refused(tmp_path, capsys, options, words):
    table.create(tmp_path / "t.h5", TASKS, KNOWN)
    write(tmp_path / "t.h5", np.arange(30), done_rows(np.arange(30)))
    assert main(["map", str(tmp_path / "t.h5"), "-o", str(tmp_path / "p.png"), *options]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "p.png").exists()


def test_a_page_of_a_large_table_holds_the_rows_that_at_leaves(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(streamed, "ROWS_MAX", 12)
    table.create(tmp_path / "t.h5", TASKS, KNOWN)
    write(tmp_path / "t.h5", np.arange(30), done_rows(np.arange(30)))
    page = tmp_path / "p.html"
    assert main(["page", str(tmp_path / "t.h5"), "-o", str(page), "--at", "N=5"]) == 0
    assert "rows      12 done of 12" in capsys.readouterr().out
    assert main(["page", str(tmp_path / "t.h5"), "-o", str(tmp_path / "q.html")]) == 2
    assert "fix parameters by --at" in capsys.readouterr().err


def test_a_large_table_without_a_finished_row_is_refused(tmp_path, capsys):
    table.create(tmp_path / "t.h5", TASKS, KNOWN)
    assert main(["best", str(tmp_path / "t.h5"), "-o", str(tmp_path / "b.png")]) == 2
    assert "has no finished row" in capsys.readouterr().err
