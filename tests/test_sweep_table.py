"""The table: created whole, allocated whole, overwritten row by row; a torn row counts as never computed."""

import errno
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep import conduct
from sweep.errors import InputError
from sweep.plan.tasks import Tasks
from sweep.schema import PENDING, REUSED, ROW, RUN_COLUMNS, is_sealed, seal
from sweep.store import table
from sweep.store.runs import new_run

from .conftest import rows_of

AXES = {"N": (5, 8), "zeta_T": (0.0, 1e-3, 1e-2), "M_over_M0": (0.5,), "V_over_V0": (1.0, 2.0)}
KNOWN = {"spec": "name = 'é'\n" * 10_000, "kernel": "abc"}


@pytest.fixture
def path(tmp_path):
    tasks = Tasks(AXES)
    table.create(tmp_path / "t.h5", tasks, KNOWN)
    return tmp_path / "t.h5"


def done_rows(path, ids) -> np.ndarray:
    """Finished rows of these tasks, with made-up numbers."""
    with h5py.File(path) as file:
        rows = file["results"][()][ids]
    rows["ke_ratio"], rows["steps"], rows["status"] = 1.0 / (2.0 + ids), ids, b"done"
    seal(rows)
    return rows


@pytest.mark.parametrize("unchecked", [True, False])
def test_whether_a_row_was_not_checked_is_asked_of_written_parts_alone(path, monkeypatch, unchecked):
    """Of a sweep of millions that was stopped early, which would take minutes."""
    monkeypatch.setattr(table, "ROWS_AT_ONCE", 2)
    rows = done_rows(path, np.array([4, 5]))
    rows["checked"] = not unchecked
    seal(rows)
    write(path, np.array([4, 5]), rows)
    monkeypatch.setattr(table, "filled_in", lambda *_: pytest.fail("a part is made up"))
    with table.reading(path) as file:
        assert conduct._any_unchecked(file) is unchecked


def write(path, ids, rows):
    with h5py.File(path, "r+") as file:
        table.write_rows(file["results"], ids, rows)


def test_a_new_table_holds_every_task_as_a_pending_row(path):
    tasks = Tasks(AXES)
    with table.reading(path) as file:
        rows = file["results"][()]
        assert table.counts(file) == (0, 0, len(tasks)) == (0, 0, 12)
        assert not table.finished(file).any()
        assert len(table.runs(file)) == 0
        assert table.attributes(file) == KNOWN
    for name, values in tasks.columns(np.arange(12)).items():
        assert np.array_equal(rows[name], values)
    assert set(rows["status"]) == {PENDING}


def test_what_is_not_computed_does_not_look_computed(path):
    rows = rows_of(path)
    for name in ROW.names:
        if ROW[name].kind == "f" and name not in ("zeta_T", "M_over_M0", "V_over_V0"):
            assert np.isnan(rows[name]).all(), name
    assert set(rows["method"]) == {b""}
    assert not rows["checked"].any()
    assert set(rows["rank"]) == {-1}


def test_the_layout_survives_a_kill(path):
    """Contiguous and allocated early: no write of a row changes the structure of the file."""
    size = path.stat().st_size
    with h5py.File(path) as file:
        for name in ("results", "runs"):
            properties = file[name].id.get_create_plist()
            assert properties.get_layout() == h5py.h5d.CONTIGUOUS
            assert properties.get_alloc_time() == h5py.h5d.ALLOC_TIME_EARLY
            assert file[name].id.get_offset() + file[name].nbytes <= size
    write(path, np.arange(12), done_rows(path, np.arange(12)))
    assert path.stat().st_size == size


@pytest.mark.parametrize("mode", ["r", "r+"])
def test_a_table_that_this_process_has_open_is_not_called_damaged(path, tmp_path, monkeypatch, mode):
    monkeypatch.chdir(tmp_path)
    with h5py.File("t.h5", mode):
        with pytest.raises(InputError) as caught, table.reading(path):
            pass
        assert caught.value.problems == (f"{path}: is open elsewhere in this process, which must close it first",)
    with table.reading(path) as file:
        assert len(file["results"]) == 12


def test_written_rows_are_finished_and_counted_whatever_their_order(path):
    ids = np.array([7, 2, 11])
    rows = done_rows(path, ids)
    rows[1]["status"] = b"step_budget"
    seal(rows)
    write(path, ids, rows)
    with table.reading(path) as file:
        assert file["results"][()][ids].tobytes() == rows.tobytes()
        assert np.flatnonzero(table.finished(file)).tolist() == [2, 7, 11]
        assert table.counts(file) == (2, 1, 9)


def test_two_orders_of_writing_give_one_table(path, tmp_path):
    table.create(tmp_path / "other.h5", Tasks(AXES), KNOWN)
    rng = np.random.default_rng(1)
    for where, batches in ((path, [np.arange(12)]), (tmp_path / "other.h5", np.split(rng.permutation(12), 4))):
        for ids in batches:
            write(where, ids, done_rows(where, ids))
    with h5py.File(path) as one, h5py.File(tmp_path / "other.h5") as other:
        assert one["results"][()].tobytes() == other["results"][()].tobytes()


@given(st.integers(0, 11), st.integers(0, ROW.itemsize - 1), st.integers(1, 255))
def test_a_row_with_one_changed_byte_counts_as_never_computed(tmp_path_factory, row, byte, change):
    path = tmp_path_factory.mktemp("torn") / "t.h5"
    table.create(path, Tasks(AXES), {})
    write(path, np.arange(12), done_rows(path, np.arange(12)))
    with h5py.File(path) as file:
        offset = file["results"].id.get_offset() + row * ROW.itemsize + byte
    content = bytearray(path.read_bytes())
    content[offset] ^= change
    path.write_bytes(content)
    with table.reading(path) as file:
        assert np.flatnonzero(~table.finished(file)).tolist() == [row]
        assert table.counts(file) == (11, 0, 1)


def test_the_checksum_covers_every_column_before_it():
    rows = np.zeros(1, ROW)
    seal(rows)
    for name in ROW.names[:-1]:
        changed = rows.copy()
        changed[name] = 1
        assert not is_sealed(changed)[0], name
    assert ROW.names[-1] == "checksum"
    assert set(RUN_COLUMNS) < set(ROW.names)


def test_a_creation_that_fails_half_way_leaves_nothing(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(table, "_fill", full)
    with pytest.raises(OSError, match="No space"):
        table.create(tmp_path / "t.h5", Tasks(AXES), KNOWN)
    assert list(tmp_path.iterdir()) == []


def test_a_quota_is_met_before_hdf5_meets_it(tmp_path, monkeypatch):
    """HDF5 1.10 crashes the process where the disk fills up under it."""
    asked = []

    def over_quota(_descriptor, _offset, size):
        asked.append(size)
        raise OSError(errno.EDQUOT, "Disk quota exceeded")

    monkeypatch.setattr(table.os, "posix_fallocate", over_quota)
    with pytest.raises(OSError, match="quota"):
        table.create(tmp_path / "t.h5", Tasks(AXES), KNOWN)
    assert list(tmp_path.iterdir()) == []
    monkeypatch.undo()
    table.create(tmp_path / "t.h5", Tasks(AXES), KNOWN)
    assert asked[0] >= (tmp_path / "t.h5").stat().st_size


def test_a_table_larger_than_the_disk_is_refused_before_anything_is_written(tmp_path):
    steps = tuple(range(2, 1_000_002))
    with pytest.raises(InputError, match=r"t\.h5: the table needs .*e\+11 GB, its disk has .* GB free"):
        table.create(tmp_path / "t.h5", Tasks({**AXES, "N": steps, "zeta_T": steps, "V_over_V0": steps}), KNOWN)
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_creation_has_left_takes_no_room_from_the_next(tmp_path, monkeypatch):
    left = tmp_path / ".t.h5.partial"
    left.write_bytes(b"half a table")
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=0 if left.exists() else 1 << 30))
    table.create(tmp_path / "t.h5", Tasks(AXES), KNOWN)
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def test_a_table_that_takes_anothers_place_while_it_is_opened_is_not_called_damaged(path, tmp_path, monkeypatch):
    table.create(tmp_path / "new.h5", Tasks(AXES), {"kernel": "new"})
    is_whole = table.structure_is_whole

    def replaced(*asked):
        (tmp_path / "new.h5").replace(path)
        return is_whole(*asked)

    monkeypatch.setattr(table, "structure_is_whole", replaced)
    with table.reading(path) as file:
        assert table.attributes(file) == KNOWN


def test_the_list_of_runs_is_filled_without_a_gap_and_then_the_last_that_computed_is_overwritten(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "RUNS_MAX", 9)
    table.create(tmp_path / "t.h5", Tasks(AXES), KNOWN)
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        taken = []
        for _ in range(11):
            taken.append(table.next_slot(file))
            file["runs"][taken[-1]] = new_run(1, "gather", "0")[0]
        assert taken == [*range(9), 8, 8]
        for reused, last in ((slice(6, None), 5), (slice(None), 8)):
            file["runs"][reused, "writer"] = REUSED
            assert table.next_slot(file) == last
