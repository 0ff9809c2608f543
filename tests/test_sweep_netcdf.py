"""What other programs read of a table: netCDF with names and units, and a crate that tells of itself."""

import hashlib
import json
import shutil
import subprocess

import h5py
import numpy as np
import pytest
import xarray

import analysis
from sweep.cli import main
from sweep.plan.tasks import Tasks
from sweep.schema import PARAMETERS, RESULTS, ROW, seal
from sweep.store.crate import crate
from sweep.store.meanings import MEANINGS, meaning, unit
from sweep.store.netcdf import grid_of, write_netcdf
from sweep.store.table import create, write_rows

from .conftest import BIN, TIME_LIMIT, changed
from .test_analysis_cli import GRID, rows

pytestmark = pytest.mark.slow


def test_every_column_has_a_meaning_and_a_unit_of_its_own():
    assert set(ROW.names) <= set(MEANINGS)
    assert (unit("wall_force"), unit("wall_force_ratio"), unit("spring.c2")) == ("k_T L", "1", "1")
    told = "estimated relative error of wall_force, wall_force_linear and wall_force_ratio"
    assert meaning("wall_force_error") == told


@pytest.fixture
def table(sweep, small_spec, tmp_path):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    return tmp_path / "t.h5"


def test_a_grid_becomes_axes_and_every_number_stands_at_its_place(sweep, table, tmp_path):
    assert sweep("export", "t.h5", "-o", "t.nc").stdout == "24 rows in t.nc\n"
    df = analysis.load(table)
    with xarray.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as found:
        assert found["ke_ratio"].dims == PARAMETERS
        for _, row in df.iterrows():
            there = found["ke_ratio"].sel({name: row[name] for name in PARAMETERS})
            assert float(there) == row["ke_ratio"]
        assert found["seconds"].attrs["units"] == "s"
        assert "Conventions" not in found.attrs  # CF's knows no units such as TE, and k_T L
        assert found["chaotic"].encoding["_FillValue"] == -1
        assert found["chaotic"].attrs["flag_meanings"].split()[1] == "yes"
        assert found["chaotic"].attrs["flag_values"][1] == 1
        assert found["N"].dtype.kind == found["steps"].dtype.kind == "i", "all are known"
        assert all(found[name].attrs["long_name"] for name in found.variables)
        assert json.loads(found.attrs["resolved"])["name"] == "small"


def test_a_file_has_and_counts_failed_and_pending_rows_too_and_all_is_refused_beside_it(tmp_path, capsys):
    """Before, --all did nothing, and the done rows alone were counted."""
    data = rows()
    data["status"][:2] = b"not_finite"
    seal(data)
    path, to = tmp_path / "t.h5", ["-o", str(tmp_path / "t.nc")]
    create(path, Tasks(dict(zip(PARAMETERS, GRID, strict=True))), {})
    with h5py.File(path, "r+") as file:  # the last five are pending
        write_rows(file[RESULTS], np.arange(len(data) - 5), data[:-5])
    assert main(["export", str(path), *to, "--all"]) == 2
    assert "sweep: --all: must not stand beside a .nc, which has a place for every row" in capsys.readouterr().err
    assert not (tmp_path / "t.nc").exists()
    assert main(["export", str(path), *to]) == 0
    assert capsys.readouterr().out.startswith(f"{len(data)} rows in ")
    with xarray.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as found:
        assert sorted(np.unique(found["status"].values, return_counts=True)[1].tolist()) == [2, 5, len(data) - 7]
        assert np.isnan(found["steps"]).sum() == 5


def test_the_file_and_the_data_frame_give_the_same_arrays(sweep, table, tmp_path):
    sweep("export", "t.h5", "-o", "t.nc")
    ours = analysis.to_xarray(analysis.load(table, done_only=False))
    with xarray.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as found:
        for name in ("ke_ratio", "error", "t_peak_linear", "steps"):
            xarray.testing.assert_equal(ours[name], found[name].load())


@pytest.mark.parametrize("room", [0, 4, 20])
def test_a_disk_that_has_no_room_for_the_file_is_one_line(table, environment, tmp_path, room):
    """`room`: kilobytes that a file may have."""
    command = [BIN / "python", "-P", "-m", "sweep", "export", "t.h5", "-o", "t.nc"]
    limited = ["bash", "-c", 'ulimit -f "$1" && exec "${@:2}"', "bash", str(room), *command]
    answer = subprocess.run(limited, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT)
    assert (answer.returncode, answer.stderr) == (2, "sweep: t.nc: cannot be written: File too large\n")
    assert [each.name for each in tmp_path.glob("*t.nc*")] == []


def test_a_list_of_tasks_that_is_no_grid_keeps_its_parameters_beside_it(table):
    found = analysis.to_xarray(analysis.load(table).iloc[[0, 5, 7]])
    assert found["ke_ratio"].dims == ("task",)
    assert set(PARAMETERS) <= set(found.coords)


def test_a_file_of_a_list_tells_flags_and_which_columns_are_coordinates_of_which(tmp_path):
    flags = np.ma.array([True, False, False], mask=[False, False, True])
    inputs = {"N": np.array([5, 8, 5]), "zeta_T": np.array([1e-3, 1e-2, 1e-2])}
    columns = {"task": np.arange(3), **inputs, "ke_ratio": np.ones(3), "chaotic": flags}
    write_netcdf(tmp_path / "t.nc", columns, ("N", "zeta_T", "M_over_M0"), {})
    with xarray.open_dataset(tmp_path / "t.nc", engine="h5netcdf", decode_cf=False) as found:
        chaotic = found["chaotic"]
        assert chaotic.values.tolist() == [1, 0, chaotic.attrs["_FillValue"]]
        assert chaotic.attrs["flag_meanings"].split() == ["no", "yes"]
        assert chaotic.attrs["flag_values"].tolist() == [0, 1]
        beside = {name: variable.attrs.get("coordinates") for name, variable in found.variables.items()}
    assert beside == {"task": None, "N": None, "zeta_T": None, "ke_ratio": "N zeta_T", "chaotic": "N zeta_T"}


def test_rows_in_another_order_are_no_grid():
    columns = {"N": np.array([5, 5, 8, 8]), "zeta_T": np.array([1.0, 2.0, 2.0, 1.0])}
    assert grid_of(columns, ("N", "zeta_T")) is None
    assert list(grid_of(columns | {"zeta_T": np.array([1.0, 2.0, 1.0, 2.0])}, ("N", "zeta_T"))) == ["N", "zeta_T"]


def test_a_crate_tells_of_every_file_in_it_and_of_every_column(sweep, table, tmp_path):
    done = sweep("export", "t.h5", "-o", "crate", "--crate")
    left = "before it is deposited, write licence and authors into crate/ro-crate-metadata.json"
    assert done.stdout == f"24 rows in crate\n{left}\n", done.stderr
    graph = {one["@id"]: one for one in json.loads((tmp_path / "crate/ro-crate-metadata.json").read_text())["@graph"]}
    files = {path.name for path in (tmp_path / "crate").iterdir()} - {"ro-crate-metadata.json"}
    assert files == {part["@id"] for part in graph["./"]["hasPart"]} == {"t.h5", "rows.csv", "spec.toml"}
    for name in files:
        assert graph[name]["sha256"] == hashlib.sha256((tmp_path / "crate" / name).read_bytes()).hexdigest()
    measured = {graph[one["@id"]]["name"] for one in graph["./"]["variableMeasured"]}
    assert measured == set(ROW.names) - {"checksum"}
    for one in graph.values():
        for link in ("license", "instrument", "about"):
            assert link not in one or one[link]["@id"] in graph
    assert sweep("export", "t.h5", "-o", "crate", "--crate").returncode == 2


def test_what_a_crate_does_not_heed_is_refused_in_a_line_each(sweep, table, tmp_path):
    (tmp_path / "crate").mkdir()
    refused = sweep("export", "t.h5", "-o", "crate", "--crate", "--force", "--all")
    assert refused.returncode == 2
    assert refused.stderr.splitlines() == [
        "sweep: --force: must not stand beside --crate: a folder is never replaced; give another -o",
        "sweep: --all: must not stand beside --crate: its table has every row, its rows.csv the done ones",
    ]
    assert not list((tmp_path / "crate").iterdir())


def test_a_crate_of_a_table_that_still_grows_tells_of_one_instant(table, tmp_path, monkeypatch):
    copied = shutil.copyfile

    def overtaken(path, copy):
        copied(path, copy)
        with changed(path) as rows:
            rows["status"] = b"pending"
            seal(rows)

    monkeypatch.setattr(shutil, "copyfile", overtaken)
    assert crate(tmp_path / "t.h5", tmp_path / "crate") == 24


def test_a_crate_names_its_table_by_a_uri(table, tmp_path):
    (tmp_path / "t.h5").rename(tmp_path / "50 % ö.h5")
    crate(tmp_path / "50 % ö.h5", tmp_path / "crate")
    graph = {one["@id"]: one for one in json.loads((tmp_path / "crate/ro-crate-metadata.json").read_text())["@graph"]}
    assert {"@id": "50%20%25%20%C3%B6.h5"} in graph["./"]["hasPart"]
    assert graph["#sweep"]["result"] == [{"@id": "50%20%25%20%C3%B6.h5"}]
