"""An adaptive sweep computes what the search asks for, the same bits whatever the ranks, the writer and the kills."""

import os
import signal

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis import load
from analysis.transition import transition
from sweep.plan.batches import Batches
from sweep.plan.spec import parse_spec
from sweep.schema import DONE, ROW
from sweep.store import table
from sweep.store.searched import UNASKED, search_of
from sweep.tell import report

from .conftest import changed, problems_of, rows_of
from .waiting import wait_for_rows, wait_for_the_lock

WRITERS = ("mpio", "gather") if h5py.get_config().mpi else ("gather",)
GRID = """
name = "falls"
[grid]
N         = [6, 9, 17, 33, 65]
zeta_T    = [6e-4, 1e-3, 3e-3]
M_over_M0 = 2
V_over_V0 = [1, 2]
[accuracy]
target = 1e-2
"""
ADAPTIVE = GRID + '[adaptive]\nfind = "level"\nuntil = 0.02\n'
SLOW = """
name = "slow falls"
[grid]
N         = [5, 20, 80, 160]
zeta_T    = { log = [2e-4, 3e-3], points = 12 }
M_over_M0 = 2
V_over_V0 = [2, 4]
[adaptive]
find = "log_slope"
until = 0.01
[accuracy]
method = "rk45"
rtol = 1e-7
"""
FIRST = 4 * 12 * 2  # tasks of SLOW before anything is asked for


@pytest.fixture
def spec(tmp_path):
    path = tmp_path / "falls.toml"
    path.write_text(ADAPTIVE)
    return path


@pytest.mark.mpi
@pytest.mark.parametrize("writer", WRITERS)
def test_three_ranks_give_the_bits_of_one(sweep, spec, tmp_path, physics, writer):
    alone = sweep("run", spec, "-o", "one.h5")
    three = sweep("run", spec, "-o", "three.h5", "--writer", writer, ranks=3)
    assert alone.returncode == three.returncode == 0
    assert alone.stdout.split(";")[0] == three.stdout.split(";")[0]
    assert physics(tmp_path / "three.h5") == physics(tmp_path / "one.h5")
    rows = rows_of(tmp_path / "three.h5")
    computed = set(rows["rank"][rows["status"] == DONE].tolist())
    assert {0, 1, 2} >= computed
    assert len(computed) > 1


def test_the_transitions_are_those_of_the_dense_grid_for_a_fraction_of_its_tasks(sweep, spec, tmp_path):
    sweep("run", spec, "-o", "found.h5")
    with table.reading(tmp_path / "found.h5") as file:
        N = np.unique(search_of(file).tasks.columns(np.arange(len(file["results"])))["N"])
    (tmp_path / "dense.toml").write_text(GRID.replace("[6, 9, 17, 33, 65]", str(N.tolist())))
    sweep("run", "dense.toml", "-o", "dense.h5")
    found, dense = load(tmp_path / "found.h5"), load(tmp_path / "dense.h5")
    assert len(found) < 0.2 * len(dense)
    ours, theirs = transition(found), transition(dense)
    assert ours["by_level"].to_list() == pytest.approx(theirs["by_level"].to_list(), nan_ok=True)
    assert ours["why_not"].to_list() == theirs["why_not"].to_list()
    assert 0 < ours["by_level"].notna().sum() < len(ours)
    same = dense.loc[found.index, ["N", "zeta_T", "V_over_V0", "ke_ratio"]]
    assert same.equals(found[["N", "zeta_T", "V_over_V0", "ke_ratio"]])


def test_the_table_tells_what_was_asked_for_and_the_plan_bounds_it(sweep, spec, planned, tmp_path):
    answer = sweep("run", spec, "-o", "t.h5")
    rows, plan, status = rows_of(tmp_path / "t.h5"), planned(spec), report.status(tmp_path / "t.h5")
    done = int(np.count_nonzero(rows["status"] == DONE))
    assert set(rows["status"].tolist()) == {DONE, UNASKED}
    assert plan["tasks"] == 30 < done < plan["at_most"]
    assert plan["table_bytes"] == pytest.approx((tmp_path / "t.h5").stat().st_size, rel=0.02)
    assert (status["tasks"], status["done"], status["left"]) == (done, done, 0)
    assert f"sweep: search, at most {plan['at_most']} tasks, 30 left; " in answer.stderr
    assert answer.stdout.startswith(f"{done} done, 0 failed, 0 left; ")
    again = sweep("run", spec, "-o", "t.h5")
    assert again.returncode == 0
    assert " tasks, 0 left; " in again.stderr
    assert rows_of(tmp_path / "t.h5").tobytes() == rows.tobytes()


def test_a_line_s_torn_row_is_computed_again_and_nothing_else(sweep, spec, tmp_path, physics):
    sweep("run", spec, "-o", "t.h5")
    before = physics(tmp_path / "t.h5")
    with changed(tmp_path / "t.h5") as rows:
        rows["ke_ratio"][np.flatnonzero(rows["status"] == DONE)[7]] = 1.0
    assert report.status(tmp_path / "t.h5")["left"] == 1
    assert " tasks, 1 left; " in sweep("run", spec, "-o", "t.h5").stderr
    assert physics(tmp_path / "t.h5") == before


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Where the uninterrupted table is kept from one test to the next."""
    return tmp_path_factory.mktemp("whole") / "whole.h5"


@pytest.mark.mpi
@pytest.mark.parametrize(("ranks", "writer"), [(1, "gather"), *((3, writer) for writer in WRITERS)])
def test_a_sweep_killed_while_it_asks_for_more_resumes_to_the_same_table(
    sweep, start, tmp_path, physics, whole, ranks, writer
):
    (tmp_path / "slow.toml").write_text(SLOW)
    if not whole.exists():
        assert sweep("run", "slow.toml", "-o", whole, ranks=2).returncode == 0
    process = start("run", "slow.toml", "-o", "t.h5", "--writer", writer, ranks=ranks)
    wait_for_rows(tmp_path / "t.h5", process, FIRST + 12)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait(60)
    wait_for_the_lock(tmp_path / "t.h5")
    before = rows_of(tmp_path / "t.h5")
    kept = before["checksum"] != 0
    assert FIRST < np.count_nonzero(kept) < np.count_nonzero(rows_of(whole)["checksum"])
    assert report.status(tmp_path / "t.h5")["left"] > 0

    again = sweep("run", "slow.toml", "-o", "t.h5", "--writer", writer, ranks=ranks)
    assert again.returncode == 0, again.stderr
    assert rows_of(tmp_path / "t.h5")[kept].tobytes() == before[kept].tobytes()
    assert physics(tmp_path / "t.h5") == physics(whole)


def test_rows_of_an_older_table_are_taken_and_lead_on(sweep, spec, tmp_path, physics):
    (tmp_path / "grid.toml").write_text(GRID)
    sweep("run", "grid.toml", "-o", "old.h5")
    sweep("run", spec, "-o", "fresh.h5")
    answer = sweep("run", spec, "-o", "t.h5", "--reuse", "old.h5")
    assert "30 rows taken from old.h5" in answer.stderr
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "fresh.h5")


def test_its_rows_merge_with_those_of_a_grid(sweep, spec, tmp_path):
    (tmp_path / "grid.toml").write_text(GRID.replace("[6, 9, 17, 33, 65]", "[5, 6, 7]"))
    sweep("run", spec, "-o", "a.h5")
    sweep("run", "grid.toml", "-o", "b.h5")
    assert sweep("merge", "a.h5", "b.h5", "-o", "t.h5").returncode == 0
    keys = [{*zip(*(load(tmp_path / f"{t}.h5")[c] for c in ROW.names[:4]), strict=True)} for t in "abt"]
    assert keys[2] == keys[0] | keys[1]
    assert report.status(tmp_path / "t.h5")["left"] == 0


def test_merged_before_it_has_ended_it_still_tells_what_is_left(sweep, spec, tmp_path):
    sweep("run", spec, "-o", "a.h5")
    with changed(tmp_path / "a.h5") as rows:
        asked = np.flatnonzero((rows["status"] == DONE) & ~np.isin(rows["N"], [6, 9, 17, 33, 65]))
        rows["status"][asked[0]] = UNASKED  # as if the run had been killed before it
    merged = sweep("merge", "a.h5", "-o", "t.h5")
    assert merged.returncode == 75
    assert report.status(tmp_path / "t.h5")["left"] == report.status(tmp_path / "a.h5")["left"] == 1


def test_nothing_is_merged_into_it(sweep, spec, tmp_path):
    (tmp_path / "grid.toml").write_text(GRID)
    for name, of in (("a.h5", spec), ("b.h5", "grid.toml")):
        sweep("run", of, "-o", name)
    before = (tmp_path / "a.h5").read_bytes()
    answer = sweep("merge", "b.h5", "-o", "a.h5")
    assert answer.returncode == 2
    assert answer.stderr == "sweep: a.h5: exists and is a search, which could not go on; give another -o\n"
    assert (tmp_path / "a.h5").read_bytes() == before


def test_shares_are_refused(sweep, spec, tmp_path):
    for arguments in (["run", spec, "-o", "t.h5", "--shard", "1/2"], ["submit", spec, "--array", "2"]):
        answer = sweep(*arguments)
        assert answer.returncode == 2
        assert "a search has no shares" in answer.stderr
        assert answer.stderr.count("\n") == 1
    assert not list(tmp_path.glob("*.h5")) + list(tmp_path.glob("*.sbatch"))


def test_another_search_does_not_go_on_in_this_table(sweep, spec):
    sweep("run", spec, "-o", "t.h5")
    spec.write_text(ADAPTIVE.replace("0.02", "0.04"))
    answer = sweep("run", spec, "-o", "t.h5")
    assert answer.returncode == 2
    assert "holds another sweep (it differs in adaptive.until)" in answer.stderr


@pytest.mark.parametrize(
    ("line", "instead", "problem"),
    [
        ('"level"', '"slope"', "adaptive.find: must be one of level, log_slope, got 'slope'"),
        ("0.02", "0.0", "adaptive.until: must be greater than or equal to 0.001, got 0.0"),
        ("0.02", "0.6", "adaptive.until: must be less than or equal to 0.5, got 0.6"),
        ("0.02", "nan", "adaptive.until: must be a finite number, got nan"),
        ("0.02", "0.02\nmost = 0", "adaptive.most: must be greater than or equal to 1, got 0"),
        ("0.02", "0.02\ntol = 1", "adaptive.tol: is not a known key, got 1"),
        ("[6, 9, 17, 33, 65]", "[5, 9]", "grid.N: an adaptive sweep starts from at least 3 values, got [5, 9]"),
        ("[adaptive]", "[[adaptive]]", "adaptive: must be a section [adaptive], got [{"),
    ],
)
def test_a_wrong_search_is_one_problem(line, instead, problem):
    (found,) = problems_of(parse_spec, ADAPTIVE.replace(line, instead), "x.toml")
    assert found.startswith(f"x.toml: {problem}")


def test_all_problems_of_a_search_are_reported_at_once():
    text = ADAPTIVE.replace("0.02", "2.0").replace('"level"', "1").replace("= 2\n", "= -2\n") + "more = 1\n"
    keys = sorted(problem.split(": ")[1] for problem in problems_of(parse_spec, text, "x"))
    assert keys == ["adaptive.find", "adaptive.more", "adaptive.until", "grid.M_over_M0"]


SECONDS = st.lists(st.floats(1e-6, 30.0), max_size=100).map(np.array)


@given(SECONDS, SECONDS, st.integers(1, 64), st.integers(0, 5))
def test_tasks_that_come_later_go_out_once_each_after_the_others_longest_first(early, late, ranks, taken_before):
    seconds = np.append(early, late).astype(float)
    batches = Batches(np.arange(len(early)), early.astype(float), ranks)
    first = [batches.take() for _ in range(taken_before)]
    batches.add(len(early) + np.arange(len(late)), late.astype(float))
    gone, rest = np.concatenate([[], *first]).astype(int), []
    assert batches.seconds_left == pytest.approx(seconds.sum() - seconds[gone].sum(), abs=1e-9)
    while len(batch := batches.take()):
        rest.append(batch)
    order = np.concatenate([[], *rest]).astype(int)
    assert sorted([*gone, *order]) == list(range(len(seconds)))
    assert order.tolist() == sorted(order.tolist(), key=lambda k: (k >= len(early), -seconds[k], k))
