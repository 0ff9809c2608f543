"""Every search goes on from whatever rows are left to the table that it would have made, on any number of ranks."""

import h5py
import numpy as np
import pytest

from kernel.method import shared_speed
from sweep.plan.search import first_alike, sharing
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, PENDING, RESULTS, RUNS, SCREENED, UNASKED, blank_of, inputs_of, seal
from sweep.store import searched
from sweep.store.lock import only_run
from sweep.store.reuse import entry
from sweep.tell import report

GRID = """
name = "any"
[grid]
N         = { log = [6, 60], points = 10 }
zeta_T    = [1e-4, 3e-3]
M_over_M0 = { log = [0.2, 5], points = 4 }
V_over_V0 = { log = [0.5, 8], points = 4 }
[accuracy]
target = 1e-2
[search]
"""
OVER = 'over = ["M_over_M0", "V_over_V0"]\n'
SEARCHES = {
    "lowest": 'find = "lowest"\n' + OVER,
    "robust": 'find = "lowest"\nrobust = 0.01\n' + OVER,
    "level": 'find = "level"\nalong = "V_over_V0"\nlevel = 0.7\nuntil = 0.2\n',
    "map": 'find = "map"\nover = ["N", "V_over_V0"]\nerror = 0.3\n',
}


@pytest.mark.mpi
@pytest.mark.parametrize("kind", SEARCHES)
def test_a_table_that_has_lost_rows_becomes_what_it_was(sweep, tmp_path, physics, kind):
    (tmp_path / "s.toml").write_text(GRID + SEARCHES[kind])
    assert sweep("run", "s.toml", "-o", "t.h5").returncode == 0
    before, rng = physics(tmp_path / "t.h5"), np.random.default_rng()
    lost = _lose(tmp_path / "t.h5", rng)
    assert report.status(tmp_path / "t.h5")["left"] > 0
    again = sweep("run", "s.toml", "-o", "t.h5", ranks=2)
    assert again.returncode == 0, again.stderr
    assert physics(tmp_path / "t.h5") == before, f"after losing {lost}"
    assert report.status(tmp_path / "t.h5")["left"] == 0


def test_while_it_runs_its_status_is_what_it_recorded_and_no_replay_of_its_rows(sweep, tmp_path, monkeypatch):
    (tmp_path / "s.toml").write_text(GRID + SEARCHES["level"])
    assert sweep("run", "s.toml", "-o", "t.h5").returncode == 0
    with h5py.File(tmp_path / "t.h5", "r+") as file:  # as if it had been killed with 7 tasks to go
        runs, rows = file[RUNS][()], file[RESULTS][()]
        runs["ended"][0], runs["left"][0] = False, 7
        runs[1] = entry(3, "a store", "1e-2", "kernel")[0]  # what the run took over stands after it
        file[RUNS][()] = runs
    assert report.status(tmp_path / "t.h5")["left"] == 0
    with only_run(tmp_path / "t.h5"), monkeypatch.context() as without:
        without.setattr(searched, "left", None)
        status = report.status(tmp_path / "t.h5")
        assert (status["running"], status["left"]) == (True, 7)
    with h5py.File(tmp_path / "t.h5", "r+") as file:  # a run may try it again, and count it as left
        rows["status"][np.flatnonzero(rows["status"] == DONE)[0]] = b"step_budget"
        done = rows["status"] != UNASKED
        some = rows[done]
        seal(some)
        rows[done] = some
        file[RESULTS][()] = rows
    with only_run(tmp_path / "t.h5"):
        status = report.status(tmp_path / "t.h5")
        assert (status["failed"], status["left"]) == (1, 0)


def _lose(path, rng) -> tuple[list[int], list[int]]:
    """Make some rows, and some of what was screened, as if they had never been computed; which."""
    with h5py.File(path, "r+") as file:
        rows, screened = file[RESULTS][()], np.empty(0, np.int64)
        done = np.flatnonzero(~np.isin(rows["status"], (PENDING, UNASKED)))
        lost = rng.choice(done, rng.integers(1, len(done)), replace=False)
        empty = blank_of({name: rows[name][lost] for name in inputs_of(rows.dtype)}, rows.dtype)
        empty["status"] = UNASKED
        rows[lost] = empty
        file[RESULTS][()] = rows
        if SCREENED in file:
            kept = file[SCREENED][()]
            screened = rng.choice(len(kept), rng.integers(1, len(kept)), replace=False)
            kept[screened] = np.zeros(1, kept.dtype)
            file[SCREENED][()] = kept
    return lost.tolist(), screened.tolist()


def test_a_damaged_table_is_repaired_from_its_rows(sweep, tmp_path, physics):
    (tmp_path / "s.toml").write_text(GRID + SEARCHES["lowest"])
    sweep("run", "s.toml", "-o", "t.h5")
    before, data = physics(tmp_path / "t.h5"), bytearray((tmp_path / "t.h5").read_bytes())
    data[:8] = b"\0" * 8
    (tmp_path / "t.h5").write_bytes(data)
    assert sweep("run", "s.toml", "-o", "t.h5").returncode == 2
    answer = sweep("run", "s.toml", "-o", "t.h5", "--repair")
    assert answer.returncode == 0, answer.stderr
    assert "rows are saved" in answer.stderr
    assert physics(tmp_path / "t.h5") == before


def test_what_shares_a_linear_chain_when_screened_differs_in_speed_alone_and_is_predicted_alike():
    axes = {"N": [5, 9], "zeta_T": [1e-3], "M_over_M0": [1.0, 2.0], "V_over_V0": np.geomspace(0.1, 10, 21).tolist()}
    tasks = Tasks(axes | {"t_end": [1.0, 2.25]})
    ids = np.random.default_rng(1).permutation(len(tasks))
    columns, like = tasks.columns(ids), tasks.columns(first_alike(tasks, ids, 0))
    for name in ("N", "M_over_M0", "t_end"):
        assert np.array_equal(columns[name], like[name])
    assert np.array_equal(shared_speed(columns["V_over_V0"]), shared_speed(like["V_over_V0"]))
    groups = len(np.unique(first_alike(tasks, ids, 0)))
    assert groups == 2 * 2 * 2 * len(np.unique(shared_speed(axes["V_over_V0"])))
    assert sharing(tasks, 0) == len(tasks) / groups
    assert sharing(tasks, 1) == 1.0  # a quantity asks for each its own
    assert np.array_equal(first_alike(tasks, ids, 1), ids)
    assert sharing(tasks, 1) == 1.0
    assert np.array_equal(first_alike(tasks, ids, 1), ids)
