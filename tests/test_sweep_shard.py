"""Shards: every task in exactly one, of nearly equal predicted cost, in a table that resumes and knows its part."""

import json
from argparse import ArgumentTypeError

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kernel.method import choose
from sweep.conduct import run
from sweep.plan.cost import predict_work
from sweep.plan.shard import Shard, dealt, parse_shard, share
from sweep.plan.tasks import Tasks
from sweep.prepare import Options
from sweep.schema import seal
from sweep.serve.stops import Stops
from sweep.store.merge import merge

from .conftest import SMALL, changed

AXES = {"N": list(range(5, 200, 7)), "zeta_T": [0.0, 1e-3, 0.1], "M_over_M0": [0.5, 2.0], "V_over_V0": [0.3, 1.0, 3.0]}
TASKS = Tasks(AXES)
EVERY = np.arange(len(TASKS))
WORK = predict_work(TASKS.columns(EVERY), choose(), certify=True)


def ids_of(shard) -> list[int]:
    return TASKS.find(shard.columns(np.arange(len(shard)))).tolist()


@given(st.integers(1, len(TASKS)))
def test_every_task_is_in_exactly_one_shard(count):
    shards = [share(TASKS, lambda ids: WORK[ids], Shard(index, count)) for index in range(1, count + 1)]
    assert sorted(task for shard in shards for task in ids_of(shard)) == EVERY.tolist()


@pytest.mark.parametrize("count", [2, 3, 8])
def test_shards_have_the_same_predicted_cost_to_a_few_percent(count):
    costs = [
        WORK[ids_of(share(TASKS, lambda ids: WORK[ids], Shard(index, count)))].sum() for index in range(1, count + 1)
    ]
    assert min(costs) > 0.97 * max(costs)


def test_the_shares_do_not_depend_on_last_bits_which_differ_between_kinds_of_processor():
    equal = np.repeat(WORK, 3)  # tasks that tie but for their last bits
    last_bits = np.random.default_rng(1).integers(-4, 5, len(equal)) * np.finfo(float).eps
    assert (dealt(equal, 2) == dealt(equal * (1.0 + last_bits), 2)).all()


@pytest.mark.parametrize("text", ["", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", "1/100001", "٣/٤", "1 / 2"])
def test_what_is_no_shard_is_refused(text):
    with pytest.raises(ArgumentTypeError, match="must be I/N"):
        parse_shard(text)


def test_a_wrong_shard_is_a_usage_error(sweep, small_spec):
    answer = sweep("run", small_spec, "-o", "t.h5", "--shard=0/2")
    assert answer.returncode == 2
    assert "--shard: must be I/N, two whole numbers with 1 <= I <= N" in answer.stderr


def test_more_shards_than_tasks_are_refused(sweep, small_spec, tmp_path):
    answer = sweep("run", small_spec, "-o", "t.h5", "--shard", "1/25")
    assert answer.returncode == 2
    assert "1/25 leaves shards without a task; the sweep has 24" in answer.stderr
    assert not (tmp_path / "t.h5").exists()


def test_a_shard_is_a_table_of_its_own_that_tells_its_part_and_resumes(sweep, small_spec, tmp_path):
    assert sweep("run", small_spec, "-o", "t.h5", "--shard", "2/5").stdout.startswith("5 done, 0 failed, 0 left")
    told = json.loads(sweep("status", "t.h5", "--json").stdout)
    assert (told["shard"], told["tasks"], told["done"], told["left"]) == ("2/5", 5, 5, 0)
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        row = file["results"][3]
        row["ke_ratio"] = 1.0
        file["results"][3] = row
    assert "5 tasks, 1 left; " in sweep("run", small_spec, "-o", "t.h5", "--shard", "2/5").stderr


@pytest.mark.parametrize("other", [["--shard", "1/5"], ["--shard", "2/4"], []])
def test_a_table_of_another_shard_is_refused(sweep, small_spec, other):
    sweep("run", small_spec, "-o", "t.h5", "--shard", "2/5")
    answer = sweep("run", small_spec, "-o", "t.h5", *other)
    assert answer.returncode == 2
    assert f"holds another shard of this sweep (2/5, not {other[1] if other else 'all'})" in answer.stderr


@pytest.mark.parametrize("status", [b"", b"pending"])
def test_a_shard_of_which_a_single_task_was_dealt_otherwise_is_refused(sweep, small_spec, tmp_path, status):
    assert sweep("run", small_spec, "-o", "t.h5", "--shard", "1/2").returncode == 0
    with changed(tmp_path / "t.h5") as rows:
        rows["V_over_V0"][5] += 1.0
        rows["status"][5] = status or rows["status"][5]
        seal(rows)
    answer = sweep("run", small_spec, "-o", "t.h5", "--shard", "1/2")
    assert (answer.returncode, answer.stderr.count("\n")) == (2, 1)
    assert "an earlier version has dealt out this shard" in answer.stderr
    assert "--reuse t.h5 and the tables of the other shards" in answer.stderr


def test_a_damaged_row_of_a_shard_is_computed_again_whatever_task_it_names(sweep, small_spec, tmp_path):
    assert sweep("run", small_spec, "-o", "t.h5", "--shard", "1/2").returncode == 0
    with changed(tmp_path / "t.h5") as rows:
        rows["V_over_V0"][5] += 1.0
        rows[7] = np.zeros((), rows.dtype)
    assert "12 tasks, 2 left; " in sweep("run", small_spec, "-o", "t.h5", "--shard", "1/2").stderr


BOX = "n = 9\nN = { linear = [5, 20] }\nzeta_T = { log = [1e-3, 1e-1] }\nM_over_M0 = 1\nV_over_V0 = 1"
POINTS = f"name = 'points'\n[points]\nsample = 'latin'\n{BOX}\n[accuracy]\ntarget = 1e-2\n"


@pytest.fixture(params=[SMALL, POINTS], ids=["grid", "points"])
def damaged(request, tmp_path, monkeypatch):
    """Options of both shards of a sweep; nothing of the first is computed, and one of its rows names another task."""
    (tmp_path / "s.toml").write_text(request.param)
    one, two = (Options(tmp_path / "s.toml", tmp_path / f"{k}.h5", shard=Shard(k, 2)) for k in (1, 2))
    with monkeypatch.context() as stopped:
        stopped.setattr(Stops, "fits", lambda *_: 0.0)
        assert run(None, one) == 75
    assert run(None, two) == 0
    with changed(one.table) as rows:
        rows["N"][1] = 21
    return one, two


def test_a_pending_row_that_is_damaged_is_computed_as_the_task_of_its_shard(damaged, tmp_path):
    assert run(None, damaged[0]) == 0
    with h5py.File(damaged[0].table) as file:
        assert set(file["results"]["status"]) == {b"done"}
        assert 21 not in file["results"]["N"]


def test_a_pending_row_that_is_damaged_brings_no_task_into_a_merged_table(damaged, tmp_path):
    tables, merged = [options.table for options in damaged], tmp_path / "merged.h5"
    told = merge(tables, merged)
    assert told["left"] == told["tasks"] - told["done"] > 0
    with h5py.File(merged) as file:
        assert 21 not in file["results"]["N"]
    assert run(None, damaged[0]) == 0
    assert merge(tables, merged)["left"] == 0
