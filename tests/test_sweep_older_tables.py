"""Tables of version 0.1.0, which do not say what was checked for chaos, serve every command."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

import analysis
from sweep.schema import LAYOUTS, RESULTS, ROW, RUN, RUNS, seal
from sweep.store import table
from sweep.store.structure import STRUCTURE, seal_structure

OLDER = "bistable-sweep table 2"


def make_older(path: Path) -> None:
    """Write a table anew as 0.1.0 did."""
    with table.reading(path) as file:
        known, rows, runs = table.attributes(file), file[RESULTS][()], file[RUNS][()]
    layout = LAYOUTS[OLDER]
    old = np.zeros(len(rows), layout)
    for name in layout.names:
        old[name] = rows[name]
    seal(old)
    path.unlink()
    with h5py.File(path, "w") as file:
        file.attrs["format"] = np.bytes_(OLDER)
        for name, text in known.items():
            file.create_dataset(f"{table.PROVENANCE}/{name}", data=np.bytes_(text.encode()))
        for name, data in ((STRUCTURE, np.zeros(1, "<u4")), (RUNS, runs.astype(RUN)), (RESULTS, old)):
            table._preallocate(file, name, len(data), data.dtype)[...] = data
    seal_structure(path)


@pytest.fixture
def old(sweep, small_spec, tmp_path):
    assert sweep("run", small_spec, "-o", "old.h5").returncode == 0
    make_older(tmp_path / "old.h5")
    with table.reading(tmp_path / "old.h5") as file:
        assert file[RESULTS].dtype != ROW
    return tmp_path / "old.h5"


@pytest.mark.parametrize("certify", [True, False])
def test_an_older_table_is_told_of_audited_exported_and_merged(sweep, small_spec, tmp_path, certify):
    small_spec.write_text(small_spec.read_text() + f"certify = {str(certify).lower()}\n")
    sweep("run", small_spec, "-o", "old.h5")
    make_older(tmp_path / "old.h5")
    assert json.loads(sweep("status", "old.h5", "--json").stdout)["done"] == 24
    assert json.loads(sweep("show", "old.h5", "--json").stdout)["reused"] == []
    audited = json.loads(sweep("audit", "old.h5", "--json").stdout)
    assert (audited["sampled"], audited["not_checked"]) == (24, 0 if certify else 24)
    assert sweep("export", "old.h5", "-o", "old.csv").returncode == 0
    assert len((tmp_path / "old.csv").read_text().splitlines()) == 25
    assert sweep("merge", "old.h5", "-o", "merged.h5").returncode == 0
    with table.reading(tmp_path / "merged.h5") as file:
        assert file[RESULTS].dtype == ROW
        assert set(file[RESULTS]["checked"].tolist()) == {certify}


def test_an_older_table_is_resumed_and_reused_with_the_same_bits(sweep, small_spec, old, physics, tmp_path):
    sweep("run", small_spec, "-o", "fresh.h5")
    answer = sweep("run", small_spec, "-o", "new.h5", "--reuse", "old.h5")
    assert "24 rows taken from old.h5" in answer.stderr
    assert sweep("run", small_spec, "-o", "old.h5").returncode == 0
    tables = [physics(tmp_path / name) for name in ("new.h5", "old.h5", "fresh.h5")]
    conditions = [np.frombuffer(bits.pop("condition")) for bits in tables]
    assert tables[0] == tables[1] == tables[2]
    assert np.isnan(conditions[0]).all()  # 0.1.0 did not keep it
    assert np.isnan(conditions[1]).all()


@pytest.mark.parametrize("certify", [True, False])
def test_an_older_table_is_loaded_with_what_it_checked(sweep, small_spec, tmp_path, certify):
    small_spec.write_text(small_spec.read_text() + f"certify = {str(certify).lower()}\n")
    sweep("run", small_spec, "-o", "old.h5")
    make_older(tmp_path / "old.h5")
    loaded = analysis.load(tmp_path / "old.h5")
    assert set(loaded["checked"]) == {certify}
    assert loaded["chaotic"].isna().all() != certify
    assert len(analysis.best(loaded)) > 0
