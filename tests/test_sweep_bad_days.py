"""Disks that are full or read-only, for real: small file systems in memory that root mounts; no parallel HDF5."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from sweep.errors import InputError
from sweep.store import writers
from sweep.tell import report

from .conftest import BIN, SMALL, clean_environment
from .waiting import wait_for_rows

ROOM = 2 << 20  # bytes of the disk; the small table takes a quarter of it


@pytest.fixture
def disk(tmp_path) -> Iterator[Path]:
    """A file system of ROOM bytes."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={ROOM}", "tmpfs", str(folder)]
    if subprocess.run(mount, capture_output=True, timeout=60, check=False).returncode:
        pytest.skip("mounting needs root")
    yield folder
    subprocess.run(["umount", "--lazy", folder], timeout=60, check=True)


def fill(folder: Path, leave: int) -> None:
    """Take all but `leave` bytes."""
    with (folder / "filler").open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, shutil.disk_usage(folder).free - leave)


def test_a_disk_too_small_for_the_table_is_refused_before_anything_is_written(sweep, small_spec, disk):
    fill(disk, leave=1 << 14)
    answer = sweep("run", small_spec, "-o", disk / "t.h5")
    assert answer.returncode == 2
    assert f"{disk}/t.h5: the table needs " in answer.stderr
    assert answer.stderr.endswith(" GB free; make room, or give another -o\n")
    assert [path.name for path in disk.iterdir()] == ["filler"]


@pytest.mark.parametrize("is_there", [True, False])
def test_a_store_on_a_full_disk_ends_no_run(sweep, small_spec, tmp_path, physics, disk, is_there):
    store = disk / "store"
    if is_there:
        assert sweep("run", small_spec, "-o", "first.h5", "--store", store).returncode == 0
        small_spec.write_text(SMALL.replace("target = 1e-2", "target = 1e-3"))  # a kind that is new to the store
    fill(disk, leave=0)
    answer = sweep("run", small_spec, "-o", "full.h5", "--store", store)
    assert answer.returncode == 0
    assert answer.stderr.count("database or disk is full; what it has is computed, and nothing more is kept\n") == 1
    assert sweep("run", small_spec, "-o", "alone.h5").returncode == 0
    assert physics(tmp_path / "full.h5") == physics(tmp_path / "alone.h5")


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_disk_that_fills_up_during_a_run_costs_no_row(sweep, start, slow_spec, tmp_path, physics, disk, ranks):
    process = start("run", slow_spec, "-o", disk / "t.h5", ranks=ranks)
    wait_for_rows(disk / "t.h5", process)
    fill(disk, leave=0)
    process.communicate(timeout=240)
    assert process.returncode == 0
    assert sweep("run", slow_spec, "-o", "elsewhere.h5", ranks=2).returncode == 0
    assert physics(disk / "t.h5") == physics(tmp_path / "elsewhere.h5")


def test_a_table_on_a_read_only_disk_can_be_read_and_is_left_alone(sweep, small_spec, tmp_path, disk):
    larger = tmp_path / "larger.toml"
    larger.write_text(SMALL.replace("[5, 8, 13]", "[3, 5, 8, 13]"))
    assert sweep("run", small_spec, "-o", disk / "t.h5").returncode == 0
    subprocess.run(["mount", "-o", "remount,ro", disk], timeout=60, check=True)
    for table in ("t.h5", "new.h5"):
        answer = sweep("run", small_spec, "-o", disk / table)
        assert answer.returncode == 2
        assert answer.stderr.startswith(f"sweep: {disk}")
        assert "ead-only file system" in answer.stderr
        assert answer.stderr.count("\n") == 1
    assert report.status(disk / "t.h5")["done"] == 24
    assert sweep("export", disk / "t.h5", "-o", "t.csv").returncode == 0
    exported = sweep("export", disk / "t.h5", "-o", disk / "t.csv")
    assert (exported.returncode, exported.stderr.count("\n")) == (2, 1)
    assert f"{disk}/t.csv: cannot be written: Read-only file system" in exported.stderr
    reused = sweep("run", larger, "-o", "t.h5", "--reuse", disk / "t.h5")
    assert "24 rows taken" in reused.stderr


def test_a_full_disk_under_the_log_stops_no_sweep(small_spec, tmp_path, disk):
    fill(disk, leave=0)
    command = [BIN / "sweep", "run", small_spec, "-o", tmp_path / "t.h5"]
    with (disk / "log").open("wb") as log:
        done = subprocess.run(command, stdout=log, stderr=log, env=clean_environment(), timeout=240, check=False)
    assert done.returncode == 0
    assert report.status(tmp_path / "t.h5")["done"] == 24
    with (disk / "log").open("ab") as log:
        command = [BIN / "sweep", "run", tmp_path / "none.toml", "-o", tmp_path / "n.h5"]
        done = subprocess.run(command, stdout=log, stderr=log, env=clean_environment(), timeout=240, check=False)
    assert done.returncode == 2, "not 120, Python's own, by which no job would be judged"


def test_without_parallel_hdf5_the_writer_that_needs_it_is_refused_and_auto_takes_the_other(monkeypatch):
    monkeypatch.setattr("h5py.get_config", lambda: SimpleNamespace(mpi=False))
    with pytest.raises(InputError, match=r"^--writer mpio: this h5py has no parallel HDF5; use --writer gather"):
        writers.choose("mpio", 2)
    assert writers.choose("auto", 2)[0] == "gather"
