"""Claims about `analysis.load`."""

import subprocess
import sys

import h5py
import numpy as np
import pandas as pd
import pytest

import analysis
from analysis.table import wall_seconds
from sweep.schema import ROW, RUNS, seal

CONTRACT = [name for name in ROW.names if name != "checksum"]


def rows(count=12, status=b"done"):
    """Sealed rows whose numbers differ from row to row."""
    made = np.zeros(count, ROW)
    for place, name in enumerate(ROW.names):
        if ROW[name].kind in "if":
            made[name] = np.arange(count) * 0.5 + place + 1
    made["chaotic"], made["checked"] = np.arange(count) % 3 == 0, np.arange(count) % 4 != 0
    made["method"], made["status"] = b"rk45", status
    seal(made)
    return made


def table(path, data):
    with h5py.File(path, "w") as file:
        file["results"] = data
    return path


def test_frame_holds_the_columns_of_the_table_bit_for_bit(tmp_path):
    data = rows()
    frame = analysis.load(table(tmp_path / "t.h5", data))
    assert list(frame.columns) == CONTRACT
    assert frame.index.name == "task"
    assert list(frame.index) == list(range(12))
    for name in CONTRACT:
        if ROW[name].kind != "S" and name != "chaotic":
            assert frame[name].dtype == ROW[name]
            np.testing.assert_array_equal(frame[name].to_numpy(), data[name])
    assert frame["chaotic"].dtype == "boolean"
    assert frame["chaotic"].isna().equals(~frame["checked"])
    np.testing.assert_array_equal(frame["chaotic"][frame["checked"]], data["chaotic"][data["checked"]])


def test_method_and_status_are_text_categories(tmp_path):
    frame = analysis.load(table(tmp_path / "t.h5", rows()))
    for name, text in (("method", "rk45"), ("status", "done")):
        assert isinstance(frame[name].dtype, pd.CategoricalDtype)
        assert set(frame[name]) == {text}


def test_half_finished_table_gives_its_done_rows_under_their_task_ids(tmp_path):
    data = rows()
    data["status"][[0, 5]] = b"pending"
    data["status"][3] = b"failed"
    seal(data)
    path = table(tmp_path / "t.h5", data)
    assert list(analysis.load(path).index) == [1, 2, 4, 6, 7, 8, 9, 10, 11]
    counts = analysis.load(path, done_only=False)["status"].value_counts()
    assert counts.to_dict() == {"done": 9, "pending": 2, "failed": 1}


def test_torn_row_is_left_out_and_told_as_torn(tmp_path):
    data = rows()
    data["ke_ratio"][4] += 1e-12
    path = table(tmp_path / "t.h5", data)
    assert 4 not in analysis.load(path).index
    assert len(analysis.load(path)) == 11
    status = analysis.load(path, done_only=False)["status"]
    assert list(status[status == "torn"].index) == [4]
    assert np.isnan(analysis.load(path, done_only=False)["ke_ratio"][4])
    assert analysis.load(path, done_only=False)["N"][4] == data["N"][4]


def test_row_torn_within_its_status_can_be_read(tmp_path):
    data = rows()
    data["status"][4] = b"\xff\x80do"
    assert len(analysis.load(table(tmp_path / "t.h5", data))) == 11


def test_table_without_checksum_is_taken_at_its_word(tmp_path):
    data = rows()
    data["status"][2] = b"failed"
    own = np.empty(12, [(name, ROW[name]) for name in CONTRACT])
    for name in CONTRACT:
        own[name] = data[name]
    assert list(analysis.load(table(tmp_path / "t.h5", own)).index) == [0, 1, *range(3, 12)]


def test_more_columns_come_along_and_do_not_disturb_the_checksum(tmp_path):
    data = rows()
    data["ke_ratio"][7] *= 2
    more = np.zeros(12, [("note", "S5"), *ROW.descr, ("energy", ">f8"), ("profile", "<f8", (3,))])
    for name in ROW.names:
        more[name] = data[name]
    more["note"], more["energy"] = b"mine", np.arange(12)
    frame = analysis.load(table(tmp_path / "t.h5", more))
    assert list(frame.index) == [0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11]
    assert set(frame["note"]) == {"mine"}
    assert frame["energy"].sum() == 66 - 7
    assert "profile" not in frame


def test_variable_length_text_is_read(tmp_path):
    text = h5py.string_dtype()
    own = np.empty(3, [(name, text if ROW[name].kind == "S" else ROW[name]) for name in CONTRACT])
    for name in CONTRACT:
        own[name] = rows(3)[name].astype(str) if ROW[name].kind == "S" else rows(3)[name]
    frame = analysis.load(table(tmp_path / "t.h5", own))
    assert len(frame) == 3
    assert set(frame["method"]) == {"rk45"}


def test_table_open_for_writing_elsewhere_is_readable(tmp_path):
    path = table(tmp_path / "t.h5", rows())
    script = (
        "import h5py, signal, sys; signal.alarm(120); f = h5py.File(sys.argv[1], 'r+'); d = f['results']; r = d[0];"
        "r['status'] = b'pending'; d[0] = r; f.flush(); print('open', flush=True); sys.stdin.readline(); f.close()"
    )
    command = [sys.executable, "-c", script, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout.readline() == "open\n"
        assert len(analysis.load(path)) == 11
        writer.communicate("\n", timeout=60)
    assert writer.returncode == 0


def test_table_without_finished_row_says_what_its_rows_are(tmp_path):
    data = rows(status=b"pending")
    data["status"][0] = b"failed"
    seal(data)
    path = table(tmp_path / "t.h5", data)
    with pytest.raises(analysis.InputError, match=r"no finished row \(1 failed, 11 pending\)"):
        analysis.load(path)
    assert len(analysis.load(path, done_only=False)) == 12


def test_table_without_rows_has_no_finished_row(tmp_path):
    with pytest.raises(analysis.InputError, match="no rows at all"):
        analysis.load(table(tmp_path / "t.h5", rows(0)))


def test_rows_that_were_not_computed_have_no_numbers_whatever_the_table_holds_there(tmp_path):
    data = rows()
    data["status"][2], data["status"][3] = b"pending", b"unasked"
    frame = analysis.load(table(tmp_path / "t.h5", data), done_only=False)
    for name in ("ke_ratio", "error", "seconds", "spread_high"):
        assert list(np.flatnonzero(frame[name].isna())) == [2, 3], name
    assert list(frame["rank"][[2, 3]]) == [-1, -1]
    assert frame["chaotic"][[2, 3]].isna().all()
    assert not frame["checked"][[2, 3]].any()


def test_a_table_that_does_not_say_what_was_checked_counts_rows_with_an_error(tmp_path):
    data = rows()
    data["error"][[1, 2]] = np.nan, np.inf
    own = np.empty(12, [(name, ROW[name]) for name in CONTRACT if name != "checked"])
    for name in own.dtype.names:
        own[name] = data[name]
    own["chaotic"] = False
    frame = analysis.load(table(tmp_path / "t.h5", own))
    assert list(frame.columns) == CONTRACT
    assert list(np.flatnonzero(~frame["checked"])) == list(np.flatnonzero(frame["chaotic"].isna())) == [1, 2]


def test_missing_columns_are_all_named(tmp_path):
    left = np.zeros(3, [(name, ROW[name]) for name in CONTRACT if name not in ("zeta_T", "error")])
    with pytest.raises(analysis.InputError, match=r"lacks the columns zeta_T, error$"):
        analysis.load(table(tmp_path / "t.h5", left))


def test_columns_of_a_wrong_type_are_named(tmp_path):
    wrong = np.zeros(3, [(name, "S4" if name == "ke_ratio" else ROW[name]) for name in CONTRACT])
    with pytest.raises(analysis.InputError, match=r"ke_ratio \(a number\)"):
        analysis.load(table(tmp_path / "t.h5", wrong))


def _group(path):
    with h5py.File(path, "w") as file:
        file.create_group("results")


def _truncated(path):
    table(path, rows(1000))
    path.write_bytes(path.read_bytes()[:5000])


def _name_of_a_column_garbled(path):
    table(path, rows(10))
    data = path.read_bytes()
    path.write_bytes(data.replace(b"ke_ratio\0", b"ke_r\x96tio\0"))


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (_name_of_a_column_garbled, "is a damaged HDF5 file"),
        (lambda path: None, "there is no table"),
        (lambda path: path.mkdir(), "is a directory"),
        (lambda path: path.write_text("N,zeta_T\n"), "is a CSV file, not a table"),
        (lambda path: path.write_bytes(b""), "is an empty file, not a table"),
        (_truncated, "is a damaged HDF5 file; `sweep run --repair` with its spec saves"),
        (lambda path: h5py.File(path, "w").close(), "no dataset /results; give the .h5 file"),
        (_group, "no dataset /results"),
        (lambda path: table(path, np.zeros(3)), "not a list of rows"),
        (lambda path: table(path, np.zeros((2, 2), ROW)), "not a list of rows"),
    ],
)
def test_path_that_is_no_table_is_refused_in_one_line(tmp_path, make, told):
    path = tmp_path / "t.h5"
    make(path)
    with pytest.raises(analysis.InputError, match=told) as caught:
        analysis.load(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("name", "told"),
    [("t.h5/x.h5", "there is no table"), ("t.h5/x/y.h5", "there is no table"), (f"{'a' * 300}.h5", "cannot be read")],
)
def test_a_name_that_no_file_can_have_is_refused_as_a_table_that_is_not_there(tmp_path, name, told):
    table(tmp_path / "t.h5", rows(2))
    with pytest.raises(analysis.InputError, match=told):
        analysis.load(tmp_path / name)


def test_importing_analysis_imports_no_matplotlib_no_scipy_no_compiler_and_no_scheduler():
    script = (
        "import sys, analysis, analysis.cli; print(*sorted(m for m in sys.modules"
        " if m.partition('.')[0] in ('matplotlib', 'mpi4py', 'numba', 'pydantic', 'scipy') or m.startswith('sweep.')))"
    )
    command = [sys.executable, "-P", "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    shared = (
        "sweep.errors sweep.files sweep.grammar sweep.log sweep.plan sweep.plan.axis sweep.plan.crossing "
        "sweep.plan.fall sweep.plan.line sweep.plan.tasks sweep.schema sweep.store sweep.store.disk "
        "sweep.store.structure sweep.store.table sweep.store.unwritten\n"
    )
    assert done.stdout == shared


def test_a_spec_in_place_of_a_table_is_told_which_command_makes_a_table_of_it(tmp_path):
    spec = tmp_path / "mine.toml"
    spec.write_text('name = "mine"\n[grid]\nN = 5\n')
    with pytest.raises(analysis.InputError) as caught:
        analysis.load(spec)
    table = tmp_path / "mine.h5"
    assert str(caught.value) == (
        f"{spec} is a spec (TOML), not a table; `sweep run {spec} -o {table}` makes a table of it: give {table}"
    )


def test_a_whole_grid_over_a_number_of_the_model_becomes_arrays_with_an_axis_of_it():
    grid = pd.MultiIndex.from_product([(5, 8), (1e-3,), (1.0,), (2.0,), (-1.0, 4.8)])
    df = grid.to_frame(index=False, name=["N", "zeta_T", "M_over_M0", "V_over_V0", "spring.c2"])
    df = df.assign(ke_ratio=[0.1, 0.2, 0.3, 0.4], chaotic=False)
    found = analysis.to_xarray(df)
    assert dict(found.sizes) == {"N": 2, "zeta_T": 1, "M_over_M0": 1, "V_over_V0": 1, "spring.c2": 2}
    assert float(found["ke_ratio"].sel({"N": 8, "spring.c2": -1.0}).squeeze()) == 0.3
    listed = analysis.to_xarray(df.iloc[[0, 3]])
    assert listed["spring.c2"].dims == ("task",)
    assert "spring.c2" in listed.coords


def test_a_damaged_run_counts_nothing_into_the_time_that_a_table_took(tmp_path):
    log = np.array([(1e9, 1e9 + 5.0), (1e9, 1e300), (0.0, 0.0)], [("start", float), ("updated", float)])
    with h5py.File(tmp_path / "t.h5", "w") as file:
        file[RUNS] = log
    assert wall_seconds(tmp_path / "t.h5") == 5.0


@pytest.mark.parametrize("locking", [True, False])
def test_a_table_that_this_program_has_open_is_read_all_the_same(tmp_path, locking):
    path = table(tmp_path / "t.h5", rows())
    with h5py.File(path, "r", locking=locking):
        assert len(analysis.load(path)) == 12
