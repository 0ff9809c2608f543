"""What a disk can do for several nodes decides who writes; what a node does not see it says."""

import os
import subprocess
import sys
from collections import Counter
from contextlib import suppress
from pathlib import Path

import h5py
import pytest

from sweep.conduct import run
from sweep.errors import InputError
from sweep.prepare import Options
from sweep.store import disk, lease, searched, table, writers

from .conftest import SMALL, clean_environment

parallel = pytest.mark.skipif(not h5py.get_config().mpi, reason="this h5py is serial")


@parallel
@pytest.mark.parametrize(
    ("kind", "hosts", "writer"),
    [
        ("ext4", 1, "mpio"),
        ("fuse.glusterfs", 1, "mpio"),
        ("fuse.glusterfs", 2, "gather"),
        ("nfs4", 2, "gather"),
        ("lustre", 2, "mpio"),
        ("gpfs", 2, "mpio"),
    ],
)
def test_auto_lets_one_node_write_where_nodes_do_not_see_each_others_pages(monkeypatch, tmp_path, kind, hosts, writer):
    monkeypatch.setattr(disk, "kind_of", lambda _: kind)
    chosen, why = writers.choose("auto", 4, hosts, tmp_path)
    assert chosen == writer
    assert (kind in why) == (writer == "gather")
    assert writers.choose("mpio", 4, hosts, tmp_path) == ("mpio", "asked for")


def test_of_file_systems_mounted_at_one_place_the_last_counts(monkeypatch, tmp_path):
    mounts = f"a / ext4 rw 0 0\nb {tmp_path} nfs4 rw 0 0\nc {tmp_path} fuse.sshfs rw 0 0\n"
    monkeypatch.setattr(disk, "Path", _reading(mounts))
    assert disk.kind_of(tmp_path / "t.h5") == "fuse.sshfs"
    assert disk.kind_of(tmp_path.parent) == "ext4"


def test_a_mount_may_have_any_name(monkeypatch, tmp_path):
    name = os.fsencode(tmp_path) + b"/\xff\xa0\x0b %d\t\\n"
    escaped = name.replace(b"\\", rb"\134").replace(b"\t", rb"\011").replace(b" ", rb"\040")
    monkeypatch.setattr(disk, "Path", _reading(b"a / ext4 rw 0 0\nb " + escaped + b" nfs4 rw 0 0\n"))
    assert disk.kind_of(Path(os.fsdecode(name)) / "t.h5") == "nfs4"
    assert disk.kind_of(tmp_path / "t.h5") == "ext4"


def _reading(text):
    class Mounts(type(Path())):  # type: ignore[misc]
        def read_bytes(self):
            return text if isinstance(text, bytes) else text.encode()

    return Mounts


def _in_memory(path):
    """How many of its bytes, from the first, this machine would not have to ask the disk for."""
    with path.open("rb", buffering=0) as file:
        try:
            return os.preadv(file.fileno(), [bytearray(path.stat().st_size)], 0, os.RWF_NOWAIT)
        except BlockingIOError:
            return 0
        except OSError as error:
            pytest.skip(f"{disk.kind_of(path)} does not tell: {error}")


@pytest.mark.parametrize(("kind", "asked_again"), [("nfs4", True), ("ext4", False)])
def test_what_was_read_of_a_table_that_other_machines_see_is_asked_of_the_disk_again(
    monkeypatch, tmp_path, kind, asked_again
):
    if disk.kind_of(tmp_path) in ("tmpfs", "ramfs"):
        pytest.skip("there is no disk")
    path, size = tmp_path / "t.h5", 1 << 20
    with path.open("wb") as file:
        file.write(bytes(size))
        file.flush()
        os.fsync(file.fileno())
    assert _in_memory(path) == size
    monkeypatch.setattr(disk, "kind_of", lambda _: kind)
    opened = len(list(Path("/proc/self/fd").iterdir()))
    disk.forget_what_was_read(path)
    assert len(list(Path("/proc/self/fd").iterdir())) == opened
    assert _in_memory(path) == (0 if asked_again else size)


def _opened(path):
    with suppress(InputError), table.reading(path):
        pass


@pytest.mark.parametrize("read", [_opened, lease.read])
def test_whoever_reads_a_table_or_a_lease_that_other_machines_see_reads_the_disk(monkeypatch, tmp_path, read):
    (tmp_path / "t").write_text("{}")
    forgotten = []
    monkeypatch.setattr(disk, "kind_of", lambda _: "nfs4")
    monkeypatch.setattr(os, "posix_fadvise", lambda descriptor, *_: forgotten.append(os.fstat(descriptor).st_ino))
    read(tmp_path / "t")
    assert forgotten == [(tmp_path / "t").stat().st_ino]


def test_a_pipe_is_not_waited_for_where_other_machines_see_it(monkeypatch, tmp_path):
    monkeypatch.setattr(disk, "kind_of", lambda _: "nfs4")
    os.mkfifo(tmp_path / "pipe")
    disk.forget_what_was_read(tmp_path / "pipe")


def test_rows_that_were_finished_and_are_not_seen_are_told_and_are_no_success(tmp_path, monkeypatch, capsys):
    (tmp_path / "small.toml").write_text(SMALL)
    monkeypatch.setattr(searched, "counts", lambda _: (Counter({"done": 20}), 4))
    assert run(None, Options(tmp_path / "small.toml", tmp_path / "t.h5")) == 75
    said = capsys.readouterr()
    assert said.out.startswith("20 done, 0 failed, 4 left; ")
    assert "4 rows that were reported finished are not in the table, as this node sees it" in said.err


UNREADABLE = """
import os, sys
from pathlib import Path
import numpy as np
from mpi4py import MPI
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, blank_of, seal
from sweep.store import table, writers
path, tasks = Path(sys.argv[1]), Tasks({"N": [5], "zeta_T": [1e-3], "M_over_M0": [2.0], "V_over_V0": [0.3, 1.0, 3.0]})
table.create(path, tasks, {})
writer = writers.Mpio(path, MPI.COMM_SELF, 3600.0)
size = path.stat().st_size
os.truncate(path, 0)  # nothing can be read any more
rows = blank_of(tasks.columns(np.arange(3)))
rows["status"] = DONE
seal(rows)
writer.write(np.arange(3), rows)
assert 0 < path.stat().st_size <= size
os._exit(0)  # the file cannot be closed in order
"""


@parallel
@pytest.mark.mpi
def test_a_rank_that_has_opened_the_table_need_not_read_of_it_to_write_its_rows(tmp_path):
    command = [sys.executable, "-P", "-c", UNREADABLE, str(tmp_path / "t.h5")]
    answer = subprocess.run(command, env=clean_environment(), capture_output=True, text=True, timeout=60, check=False)
    assert answer.returncode == 0, answer.stderr


def test_what_hdf5_says_of_a_disk_in_its_own_way_is_a_message_too(tmp_path):
    refused = pytest.raises(InputError, match=r"cannot be written any more \(Unable to flush")
    with refused, writers.Waiting().on(tmp_path):
        raise RuntimeError("Unable to flush  file's cached information")
