"""Exported rows are the table's, number for number."""

import csv

import h5py
import numpy as np
import pandas as pd
import pytest

from sweep import schema
from sweep.errors import InputError
from sweep.plan.tasks import Tasks
from sweep.store import export as module
from sweep.store.export import export
from sweep.store.table import create

NAMES = [name for name in schema.ROW.names if name != "checksum"]


@pytest.fixture
def rows(sweep, small_spec, tmp_path):
    """Of t.h5: 24 done ones, but row 3 failed, row 5 torn and row 7 pending."""
    sweep("run", small_spec, "-o", "t.h5")
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        rows = file["results"][()]
        rows["status"][[3, 7]] = b"step_budget", b"pending"
        schema.seal(rows)
        rows["ke_ratio"][5] = 1.0
        file["results"][()] = rows
        return rows


def test_csv_holds_the_done_rows_exactly(sweep, rows, tmp_path):
    assert sweep("export", "t.h5", "-o", "t.csv").stdout == "21 rows in t.csv\n"
    with (tmp_path / "t.csv").open(newline="") as file:
        told = list(csv.DictReader(file))
    assert list(told[0]) == ["task", *NAMES]
    for line in told:
        row = rows[int(line["task"])]
        assert line["status"] == "done"
        assert all(np.array_equal(float(line[name]), row[name], equal_nan=True) for name in ("zeta_T", "ke_ratio"))
        assert line["method"] == row["method"].decode()


def test_all_rows_come_when_asked_for_and_say_what_they_are(sweep, rows, tmp_path):
    assert sweep("export", "t.h5", "-o", "t.csv", "--all").stdout == "24 rows in t.csv\n"
    with (tmp_path / "t.csv").open(newline="") as file:
        status = [line["status"] for line in csv.DictReader(file)]
    assert (status[3], status[5], status[7], status[0]) == ("step_budget", "torn", "pending", "done")


@pytest.mark.parametrize("certify", ["true", "false"])
def test_what_is_not_known_is_empty_in_either_form(sweep, small_spec, tmp_path, certify):
    """A half-finished table: pending rows, and where nobody checked the flag of the done ones."""
    small_spec.write_text(small_spec.read_text() + f"certify = {certify}\n")
    sweep("run", small_spec, "-o", "shard.h5", "--shard", "1/2")
    sweep("merge", "shard.h5", "-o", "t.h5")
    for output in ("t.csv", "t.parquet"):
        assert sweep("export", "t.h5", "-o", output, "--all").returncode == 0
    csv_told = pd.read_csv(tmp_path / "t.csv", keep_default_na=False, na_values=["", "nan"])
    for told in (csv_told, pd.read_parquet(tmp_path / "t.parquet")):
        pending = told[told["status"] == "pending"]
        assert 0 < len(pending) < len(told)
        unknown = ["ke_ratio", "error", "chaotic", "spread_low", "steps", "seconds", "rank"]
        assert pending[unknown].isna().all(axis=None)
        assert not pending["checked"].any()
        done = told[told["status"] == "done"]
        assert done[["ke_ratio", "steps", "rank"]].notna().all(axis=None)
        assert (done["checked"] == (certify == "true")).all()
        assert (done["chaotic"].notna() == done["checked"]).all()


def test_of_a_task_that_raised_the_steps_are_not_known_but_who_computed_it(sweep, rows, tmp_path):
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        rows = file["results"][()]
        blank = schema.without_numbers(rows, np.arange(len(rows)) == 2)
        blank["status"][2], blank["rank"][2] = b"error", 0
        schema.seal(blank)
        file["results"][()] = blank
    sweep("export", "t.h5", "-o", "t.csv", "--all")
    told = pd.read_csv(tmp_path / "t.csv").iloc[2]
    assert (told["status"], told["rank"], np.isnan(told["steps"])) == ("error", 0, True)


@pytest.mark.parametrize("name", ["t.csv", "t.parquet"])
def test_a_file_that_is_there_is_replaced_only_with_force(sweep, rows, tmp_path, name):
    (tmp_path / name).write_text("mine")
    refused = sweep("export", "t.h5", "-o", name)
    assert (refused.returncode, refused.stderr) == (
        2,
        f"sweep: {name}: exists; give another -o, or --force to replace it\n",
    )
    assert (tmp_path / name).read_text() == "mine"
    assert sweep("export", "t.h5", "-o", name, "--force").returncode == 0
    assert (tmp_path / name).read_bytes()[:4] in (b"task", b"PAR1")


def test_the_function_too_replaces_nothing_unless_it_is_told_to(tmp_path):
    mine = tmp_path / "rows.csv"
    mine.write_text("mine")
    with pytest.raises(InputError, match=r"rows\.csv: exists"):
        export(tmp_path / "t.h5", mine)
    assert mine.read_text() == "mine"


def test_parquet_holds_the_done_rows_exactly_and_the_provenance(sweep, rows, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    assert sweep("export", "t.h5", "-o", "t.parquet").stdout == "21 rows in t.parquet\n"
    told = parquet.read_table(tmp_path / "t.parquet")
    assert told.column_names == ["task", *NAMES]
    mine = rows[told["task"].to_numpy()]
    for name in NAMES:
        column = np.array(told[name].to_pylist())
        assert np.array_equal(column.astype(mine[name].dtype), mine[name], equal_nan=mine[name].dtype.kind == "f")
    assert b'"name": "small"' in told.schema.metadata[b"resolved"]


def test_parquet_without_pyarrow_says_what_to_do(sweep, rows, environment, tmp_path):
    (tmp_path / "pyarrow.py").write_text("raise ImportError")
    answer = sweep("export", "t.h5", "-o", "t.parquet", env=environment | {"PYTHONPATH": str(tmp_path)})
    assert answer.returncode == 2
    assert answer.stderr == "sweep: .parquet needs pyarrow: pip install 'bistable-sweep[parquet]'; .csv does not\n"
    assert not (tmp_path / "t.parquet").exists()


@pytest.mark.parametrize(
    ("table", "output", "told"),
    [
        ("t.h5", "t.xlsx", "t.xlsx: must end with .csv, .parquet or .nc"),
        ("none.h5", "t.csv", "none.h5: cannot be read: No such file or directory"),
        ("t.h5", "none/t.csv", "none/t.csv: cannot be written: No such file or directory"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(sweep, rows, tmp_path, table, output, told):
    before = sorted(tmp_path.rglob("*"))
    answer = sweep("export", table, "-o", output)
    assert (answer.returncode, answer.stderr) == (2, f"sweep: {told}\n")
    assert sorted(tmp_path.rglob("*")) == before


def test_two_exports_to_one_file_at_once_leave_one_of_them_whole(tmp_path, monkeypatch):
    axes = {"N": [5], "zeta_T": [0.0], "M_over_M0": [1.0]}
    for name, values in (("one.h5", [1.0]), ("two.h5", [1.0, 2.0])):
        create(tmp_path / name, Tasks(axes | {"V_over_V0": values}), {})
    output, write = tmp_path / "rows.csv", module._write_csv

    def beside_another(*asked):
        monkeypatch.setattr(module, "_write_csv", write)
        count = write(*asked)
        export(tmp_path / "two.h5", output, everything=True)
        return count

    monkeypatch.setattr(module, "_write_csv", beside_another)
    assert export(tmp_path / "one.h5", output, everything=True) == 1
    assert len(output.read_text().splitlines()) == 2
    assert {path.name for path in tmp_path.iterdir()} == {"one.h5", "two.h5", "rows.csv"}


def test_a_table_is_not_replaced_by_its_own_export(tmp_path):
    (tmp_path / "t.csv").write_text("a table, by an earlier version")
    with pytest.raises(InputError, match=r"t\.csv: is the table itself; give another -o"):
        export(tmp_path / "t.csv", tmp_path / "t.csv", force=True)
