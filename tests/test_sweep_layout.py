"""Tables of version 0.1.0, whose rows do not say what was checked: they are read, and told as what they are."""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest

import analysis
from sweep.plan.sections import Accuracy
from sweep.plan.tasks import Tasks
from sweep.schema import LAYOUTS, PARAMETERS, ROW, as_rows, is_ended, is_sealed
from sweep.store import table
from sweep.store.merge import merge
from sweep.store.reuse import reuse
from sweep.tell import report

from .conftest import changed, rows_of

DATA = Path(__file__).parent / "data"
OLD = LAYOUTS["bistable-sweep table 2"]
SPEC = """
name = "old"
[grid]
N         = [5, 60]
zeta_T    = [0.0, 4e-5]
M_over_M0 = [0.5, 2]
V_over_V0 = [0.3, 1, 5]
[accuracy]
target = 1e-2
"""
AXES = {"N": (5, 60), "zeta_T": (0.0, 4e-5), "M_over_M0": (0.5, 2.0), "V_over_V0": (0.3, 1.0, 5.0)}


def unpacked(name, folder):
    path = folder / f"{name}.h5"
    path.write_bytes(gzip.decompress((DATA / f"table2-{name}.h5.gz").read_bytes()))
    return path


@pytest.fixture
def half(tmp_path):
    """24 rows by 0.1.0, certified: 12 done, one of them chaotic, 12 pending."""
    return unpacked("half", tmp_path)


@pytest.fixture
def unchecked(tmp_path):
    """The same tasks, all done, by certify = false."""
    return unpacked("unchecked", tmp_path)


def test_a_row_of_today_is_longer_by_the_condition_number_and_one_byte():
    assert ROW.itemsize == OLD.itemsize + 9
    assert list(ROW.names).index("checked") == list(ROW.names).index("chaotic") + 1
    assert [name for name in ROW.names if name not in ("condition", "checked")] == list(OLD.names)


def test_its_rows_are_loaded_as_checked_where_they_have_an_error(half):
    df, rows = analysis.load(half), rows_of(half)
    assert rows.dtype == OLD
    assert len(df) == 12
    assert df["checked"].all()
    assert df["chaotic"].sum() == 1
    for name in ("ke_ratio", "error", "spread_low"):
        np.testing.assert_array_equal(df[name].to_numpy(), rows[name][df.index])


def test_what_it_has_not_computed_is_nan(half):
    df = analysis.load(half, done_only=False)
    pending = df[df["status"] == "pending"]
    assert len(pending) == 12
    assert pending.select_dtypes("floating").drop(columns=list(PARAMETERS[1:])).isna().all(axis=None)
    assert pending["chaotic"].isna().all()
    assert not pending["checked"].any()
    assert set(pending["method"]) == {""}
    assert df["ke_ratio"].min() > 0.4


def test_what_it_has_not_checked_is_told_as_not_checked(unchecked):
    df = analysis.load(unchecked)
    assert not df["checked"].any()
    assert df["chaotic"].isna().all()
    assert "error not estimated, not checked for chaos" in str(analysis.optimum(df))


def test_its_checksums_are_checked_by_its_own_columns(half):
    with changed(half) as rows:
        assert is_ended(rows).sum() == 12
        rows["ke_ratio"][0] += 1e-9
    assert is_ended(as_rows(rows)).sum() == 11
    assert np.isnan(as_rows(rows)["ke_ratio"][0])
    assert report.status(half)["done"] == 11
    assert analysis.load(half, done_only=False)["status"].value_counts()["torn"] == 1


def test_status_and_show_tell_it(half):
    told = report.status(half)
    assert (told["done"], told["failed"], told["left"]) == (12, 0, 12)
    shown = report.show(half)
    assert shown["versions"]["bistable-sweep"] == "0.1.0"
    assert shown["reused"] == []


def test_merged_it_has_todays_rows_with_its_numbers(half, tmp_path):
    merge([half], tmp_path / "new.h5")
    old, new = rows_of(half), rows_of(tmp_path / "new.h5")
    assert new.dtype == ROW
    ended = is_ended(old)
    assert np.array_equal(ended, is_ended(new))
    for name in set(OLD.names) - {"checksum"}:
        assert old[name][ended].tobytes() == new[name][ended].tobytes(), name
    assert np.array_equal(new["checked"], ended)
    assert np.isnan(new["condition"]).all()  # 0.1.0 did not keep it


def test_its_rows_can_be_reused(half, unchecked, tmp_path):
    for old, count in ((half, 12), (unchecked, 24)):
        path = tmp_path / f"from-{old.name}"
        table.create(path, Tasks(AXES), {})
        assert reuse(path, Tasks(AXES), old, Accuracy(target=1e-2, certify=old == half)) == count
        assert rows_of(path)["checked"].sum() == (12 if old == half else 0)
        done = is_ended(rows_of(old))
        assert rows_of(path)["ke_ratio"][done].tobytes() == rows_of(old)["ke_ratio"][done].tobytes()


@pytest.mark.parametrize("output", ["half.csv", "half.parquet"])
def test_it_is_exported(sweep, half, tmp_path, output):
    if output.endswith(".parquet"):
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    assert sweep("export", half, "-o", output, "--all").stdout == f"24 rows in {output}\n"
    assert (tmp_path / output).exists()


def test_it_is_audited(sweep, half):
    answer = sweep("audit", half, "--fraction", "0.2")
    assert answer.returncode == 0, answer.stderr
    assert "12 done rows" in answer.stdout


def test_audited_it_tells_what_nobody_checked(sweep, unchecked):
    audited = json.loads(sweep("audit", unchecked, "--fraction", "0.2", "--json").stdout)
    assert audited["not_checked"] == audited["sampled"] > 0


def test_resumed_with_keep_rows_it_becomes_a_table_of_today(sweep, half, tmp_path):
    (tmp_path / "old.toml").write_text(SPEC)
    before = rows_of(half)
    refused = sweep("run", "old.toml", "-o", half)
    assert refused.returncode == 2
    assert "--keep-rows" in refused.stderr
    assert rows_of(half).tobytes() == before.tobytes()
    answer = sweep("run", "old.toml", "-o", half, "--keep-rows")
    assert answer.returncode == 0, answer.stderr
    assert "half.h5: was written by an earlier version" in answer.stderr
    after, ended = rows_of(half), is_ended(before)
    assert after.dtype == ROW
    assert is_sealed(after).all()
    assert after["checked"].all()
    for name in set(OLD.names) - {"checksum"}:
        assert before[name][ended].tobytes() == after[name][ended].tobytes(), name
    with table.reading(half) as file:
        assert len(table.runs(file)) == 3, "shard, merge, and this run"


def test_recomputed_it_is_replaced(sweep, half, tmp_path):
    (tmp_path / "old.toml").write_text(SPEC)
    assert sweep("run", "old.toml", "-o", half, "--recompute").returncode == 0
    assert rows_of(half).dtype == ROW
    assert report.status(half)["done"] == 24
