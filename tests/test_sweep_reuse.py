"""A larger sweep takes the rows that an older table has, and only those that it would compute to the same bits."""

import h5py
import numpy as np
import pytest

from sweep.store.structure import seal_structure

from .conftest import SMALL


@pytest.fixture
def larger(tmp_path):
    """The small sweep with one more N."""
    path = tmp_path / "larger.toml"
    path.write_text(SMALL.replace("[5, 8, 13]", "[3, 5, 8, 13]"))
    return path


def test_finished_rows_of_older_tables_are_taken_and_the_table_is_the_same(
    sweep, small_spec, larger, tmp_path, physics
):
    sweep("run", small_spec, "-o", "old.h5", "--shard", "1/3")
    sweep("run", small_spec, "-o", "older.h5", "--shard", "3/3")
    sweep("run", larger, "-o", "fresh.h5")
    answer = sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5", "--reuse", "older.h5", ranks=2)
    assert answer.returncode == 0
    assert "8 rows taken from old.h5" in answer.stderr
    assert "8 rows taken from older.h5" in answer.stderr
    assert "32 tasks, 16 left; " in answer.stderr
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "fresh.h5")
    again = sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5")
    assert "0 rows taken from old.h5" in again.stderr


def test_torn_and_failed_rows_are_not_taken(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "old.h5")
    with h5py.File(tmp_path / "old.h5", "r+") as file:
        rows = file["results"][()]
        rows["ke_ratio"][2] = 1.0
        file["results"][()] = rows
    assert "23 rows taken from old.h5" in sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5").stderr


def test_tables_that_cannot_be_reused_are_all_named_and_nothing_is_written(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "kernel.h5")
    with h5py.File(tmp_path / "kernel.h5", "r+") as file:
        del file["provenance/kernel"]
        file["provenance/kernel"] = np.bytes_("0123456789abcdef")
    seal_structure(tmp_path / "kernel.h5")
    small_spec.write_text(SMALL.replace("1e-2", "1e-3"))
    sweep("run", small_spec, "-o", "finer.h5")
    olds = [f"--reuse={name}" for name in ("kernel.h5", "finer.h5", "none.h5")]
    answer = sweep("run", larger, "-o", "t.h5", *olds)
    assert answer.returncode == 2
    assert answer.stderr.splitlines() == [
        "sweep: --reuse kernel.h5: was computed by another version of the kernel",
        "sweep: --reuse finer.h5: was computed with another accuracy (it differs in target)",
        "sweep: none.h5: cannot be read: No such file or directory",
    ]
    assert not (tmp_path / "t.h5").exists()


def test_recompute_throws_away_the_rows_of_another_kernel_and_only_those(sweep, small_spec, tmp_path, physics):
    sweep("run", small_spec, "-o", "fresh.h5")
    sweep("run", small_spec, "-o", "t.h5")
    assert "24 tasks, 0 left; " in sweep("run", small_spec, "-o", "t.h5", "--recompute").stderr
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        runs = file["runs"][()]
        runs["kernel"][0] = b"0123456789abcdef"  # as after --keep-rows, under a name that has changed back
        file["runs"][()] = runs
    refused = sweep("run", small_spec, "-o", "t.h5")
    assert refused.returncode == 2
    assert "or --keep-rows to keep its finished rows all the same, or --recompute to throw them away" in refused.stderr
    assert "24 tasks, 24 left; " in sweep("run", small_spec, "-o", "t.h5", "--recompute").stderr
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "fresh.h5")
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0


def test_a_table_cannot_be_reused_for_itself(sweep, small_spec, tmp_path):
    sweep("run", small_spec, "-o", "t.h5")
    before = (tmp_path / "t.h5").read_bytes()
    answer = sweep("run", small_spec, "-o", "t.h5", "--reuse", "./t.h5")
    assert answer.returncode == 2
    assert answer.stderr == "sweep: --reuse t.h5: is the table that is to be written\n"
    assert (tmp_path / "t.h5").read_bytes() == before


def test_a_table_open_elsewhere_takes_nothing_and_says_so(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "old.h5")
    sweep("run", larger, "-o", "t.h5", "--shard", "1/1")
    with h5py.File(tmp_path / "t.h5", "r+"):
        answer = sweep("run", larger, "-o", "t.h5", "--shard", "1/1", "--reuse", "old.h5")
    assert answer.returncode == 2
    assert answer.stderr.startswith("sweep: t.h5: ")
    assert "Traceback" not in answer.stderr
