"""What is not one of our tables is refused by name, whatever it is."""

import os

import h5py
import numpy as np
import pytest

from sweep.errors import InputError
from sweep.plan.tasks import Tasks
from sweep.store import table
from sweep.tell import report

from .conftest import problems_of

AXES = {"N": (5,), "zeta_T": (0.0,), "M_over_M0": (1.0,), "V_over_V0": (1.0,)}


def foreign_hdf5(path):
    with h5py.File(path, "w") as file:
        file["results"] = np.zeros(3)


def other_columns(path):
    with h5py.File(path, "w") as file:
        file.attrs["format"] = np.bytes_(table.FORMAT)
        file["results"] = np.zeros(3, [("N", int)])


def truncated(path):
    table.create(path, Tasks(AXES), {})
    path.write_bytes(path.read_bytes()[:-1000])


def no_results(path):
    table.create(path, Tasks(AXES), {})
    with h5py.File(path, "r+") as file:
        del file["results"]


def no_list_of_runs(path):
    table.create(path, Tasks(AXES), {})
    with h5py.File(path, "r+") as file:
        del file["runs"]


def results_is_a_group(path):
    table.create(path, Tasks(AXES), {})
    with h5py.File(path, "r+") as file:
        del file["results"]
        file.create_group("results")


MAKERS = {
    "foreign HDF5": foreign_hdf5,
    "our name on other columns": other_columns,
    "truncated": truncated,
    "no results": no_results,
    "no list of runs": no_list_of_runs,
    "results is a group": results_is_a_group,
    "text": lambda path: path.write_text("N,zeta_T\n"),
    "empty": lambda path: path.write_bytes(b""),
    "directory": lambda path: path.mkdir(),
    "pipe": os.mkfifo,
    "missing": lambda path: None,
    "a loop of links": lambda path: path.symlink_to(path),
    "too long a name": None,
}


@pytest.mark.parametrize("kind", MAKERS)
def test_what_is_not_a_table_is_refused_by_name(tmp_path, kind):
    path = tmp_path / "t.h5"
    if MAKERS[kind] is None:
        path = tmp_path / ("t" * 300)
    else:
        MAKERS[kind](path)
    for reader in (report.status, report.show):
        (problem,) = problems_of(reader, path)
        assert problem.startswith(f"{path}: ")
        assert "\n" not in problem


def test_a_table_cut_off_anywhere_is_refused(tmp_path):
    """What an interrupted copy leaves."""
    path = tmp_path / "t.h5"
    table.create(path, Tasks(AXES), {"resolved": "{}"})
    whole = path.read_bytes()
    for length in range(len(whole) // 40, len(whole), len(whole) // 40):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"t\.h5: is not a readable HDF5 file"):
            report.status(path)


def test_a_table_cut_off_beneath_its_run_which_writes_on_is_told_to_be_damaged_and_how_it_is_repaired(tmp_path):
    """The rows that are written afterwards make the file long again, with zeros in between."""
    path, refused = tmp_path / "t.h5", 0
    table.create(path, Tasks(AXES), {"resolved": "{}"})
    size = path.stat().st_size
    whole = path.read_bytes()
    for length in range(0, size, size // 200):
        path.write_bytes(whole[:length] + bytes(size - length))
        try:
            report.show(path)
        except InputError as error:
            refused += 1
            assert "`sweep run --repair` with its spec saves the intact rows" in str(error)
    assert refused > 2


@pytest.mark.parametrize("where", [b"SNOD", b"HEAP", b"TREE"])
def test_a_table_whose_structure_is_damaged_is_refused(tmp_path, where):
    path = tmp_path / "t.h5"
    table.create(path, Tasks(AXES), {"resolved": "{}"})
    path.write_bytes(path.read_bytes().replace(where, b"????"))
    with pytest.raises(InputError, match=r"t\.h5: is "):
        report.status(path)
