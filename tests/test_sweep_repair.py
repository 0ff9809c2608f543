"""A damaged table is found, said so, and repaired: intact rows are kept, the others computed again."""

import errno
import os
import threading
from contextlib import nullcontext

import h5py
import numpy as np
import pytest

from sweep.errors import InputError
from sweep.plan.spec import parse_spec
from sweep.store import structure, table
from sweep.store.repair import rescued
from sweep.store.writers import Flusher, Waiting

from .conftest import SMALL

REMEDY = "`sweep run --repair` with its spec saves the intact rows and computes the others"


@pytest.fixture
def whole(sweep, small_spec, tmp_path):
    """A complete table."""
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    return tmp_path / "t.h5"


def flip(path, place, bit=0):
    raw = bytearray(path.read_bytes())
    raw[place] ^= 1 << bit
    path.write_bytes(raw)


def places(path) -> list[tuple[int, int]]:
    """Offset and length of rows, list of runs and checksum."""
    with table.reading(path) as file:
        return sorted(structure.place(file[name]) for name in ("results", "runs", "structure"))


def test_a_flipped_bit_anywhere_in_the_structure_is_found(whole):
    changing, size = [(20, 4), *places(whole)], whole.stat().st_size
    inside = np.zeros(size, bool)
    for offset, length in changing:
        inside[offset : offset + length] = True
    outside = set(np.flatnonzero(~inside).tolist())
    beside = outside & {edge for offset, length in changing for edge in (offset - 1, offset + length)}
    for place in {*np.random.default_rng(1).choice(sorted(outside), 60, replace=False).tolist(), *beside}:
        flip(whole, place)
        with pytest.raises(InputError), table.reading(whole):
            pass
        flip(whole, place)
    with table.reading(whole):
        pass


def test_a_table_that_was_open_for_writing_when_its_run_was_killed_is_whole(whole):
    closed = whole.read_bytes()
    with h5py.File(whole, "r+") as file:
        file.flush()
        killed = whole.read_bytes()
    assert killed != closed  # it says that somebody writes it
    whole.write_bytes(killed)
    with table.reading(whole):
        pass


def test_a_flipped_bit_in_a_row_costs_this_row_only(sweep, small_spec, whole, physics):
    before = physics(whole)
    rows = max(places(whole), key=lambda place: place[0])[0]
    flip(whole, rows + 200)
    with table.reading(whole) as file:
        assert np.count_nonzero(~table.finished(file)) == 1
    again = sweep("run", small_spec, "-o", "t.h5")
    assert again.returncode == 0
    assert "24 tasks, 1 left" in again.stderr
    assert physics(whole) == before


@pytest.mark.parametrize("damage", ["superblock", "cut off"])
def test_a_damaged_table_is_refused_with_the_remedy_and_repaired(sweep, small_spec, whole, tmp_path, physics, damage):
    before = physics(whole)
    if damage == "superblock":
        flip(whole, 3)
    else:
        os.truncate(whole, whole.stat().st_size - 100)
    broken = whole.read_bytes()
    refused = sweep("run", small_spec, "-o", "t.h5")
    assert refused.returncode == 2
    assert len(refused.stderr.splitlines()) == 1
    assert REMEDY in refused.stderr
    assert whole.read_bytes() == broken

    repaired = sweep("run", small_spec, "-o", "t.h5", "--repair")
    assert repaired.returncode == 0
    kept = 24 if damage == "superblock" else 23
    assert f"{kept} of 24 rows are saved" in repaired.stderr
    assert f"24 tasks, {24 - kept} left" in repaired.stderr
    assert physics(whole) == before
    assert (tmp_path / "t.h5.damaged").read_bytes() == broken


@pytest.fixture
def one_name(monkeypatch):
    """A disk on which a file has one name only."""

    def refused(*_args):
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr("os.link", refused)


def rescue(path):
    spec = parse_spec(SMALL, "s")
    return rescued(path, spec.task_list(), tuple(spec.identity_texts()), spec.layout())


def test_where_a_file_has_one_name_only_a_copy_of_the_damaged_one_is_kept(whole, tmp_path, one_name):
    flip(whole, 3)
    broken = whole.read_bytes()
    assert len(rescue(whole)[0]) == 24
    assert (tmp_path / "t.h5.damaged").read_bytes() == broken
    assert len(rescue(whole)[0]) == 24  # the first repair was interrupted
    flip(whole, 5)
    os.utime(whole, ns=((tmp_path / "t.h5.damaged").stat().st_mtime_ns,) * 2)  # of one size and time, not alike
    with pytest.raises(InputError, match=r"t\.h5\.damaged: is there already, from an earlier repair; move it away"):
        rescue(whole)
    assert (tmp_path / "t.h5.damaged").read_bytes() == broken
    assert not list(tmp_path.glob(".*"))


def test_a_damaged_table_that_cannot_be_kept_is_not_repaired(whole, tmp_path, one_name, monkeypatch):
    def full(*_args):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    flip(whole, 3)
    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(InputError, match=r"t\.h5\.damaged: cannot be written: No space left on device"):
        rescue(whole)
    assert [path.name for path in tmp_path.glob("*t.h5*")] == ["t.h5"]


def test_rows_whose_accuracy_cannot_be_told_are_computed_again(sweep, small_spec, whole, physics):
    before, raw = physics(whole), whole.read_bytes()
    flip(whole, raw.index(b'"accuracy": {') + 20)
    repaired = sweep("run", small_spec, "-o", "t.h5", "--repair")
    assert repaired.returncode == 0
    assert "0 of 24 rows are saved" in repaired.stderr
    assert physics(whole) == before


def test_a_file_that_is_no_table_is_not_touched(sweep, small_spec, tmp_path):
    (tmp_path / "notes.h5").write_text("my notes")
    answer = sweep("run", small_spec, "-o", "notes.h5", "--repair")
    assert answer.returncode == 2
    assert "holds no trace of this sweep" in answer.stderr
    assert (tmp_path / "notes.h5").read_text() == "my notes"
    assert not (tmp_path / "notes.h5.damaged").exists()


def test_rows_are_flushed_every_so_often_and_at_the_end(tmp_path, monkeypatch):
    calls = []
    enough = threading.Event()

    def fsync(descriptor):
        calls.append(descriptor)
        if len(calls) == 3:
            enough.set()

    monkeypatch.setattr("os.fsync", fsync)
    (tmp_path / "t").touch()
    flusher = Flusher(tmp_path / "t", 0.01, Waiting())
    assert enough.wait(60)
    before = len(calls)
    flusher.close()
    assert len(calls) > before


@pytest.mark.parametrize(("number", "told"), [(errno.EIO, True), (errno.EINVAL, False)])
def test_what_the_disk_has_not_taken_is_no_success(tmp_path, monkeypatch, number, told, capsys):
    def fsync(_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("os.fsync", fsync)
    (tmp_path / "t").touch()
    flusher = Flusher(tmp_path / "t", 60, Waiting())
    with pytest.raises(InputError, match="may be lost; mend the disk") if told else nullcontext():
        flusher.close()
    assert ("cannot flush (Invalid argument); a power failure may cost rows" in capsys.readouterr().err) is not told


def test_how_often_is_the_specs_choice_and_no_other_sweep(sweep, small_spec, whole, tmp_path):
    other = tmp_path / "other.toml"
    other.write_text(small_spec.read_text() + "[output]\nflush_every = 5\n")
    assert sweep("run", other, "-o", "t.h5").returncode == 0
    other.write_text(small_spec.read_text() + "[output]\nflush_every = 0\n")
    refused = sweep("run", other, "-o", "t.h5")
    assert refused.returncode == 2
    assert "output.flush_every: " in refused.stderr
