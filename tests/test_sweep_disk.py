"""What a disk can do for several nodes decides who writes; what a node does not see it says."""

from collections import Counter

import h5py
import pytest

from sweep.conduct import run
from sweep.prepare import Options
from sweep.store import disk, searched, writers

from .conftest import SMALL

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


def _reading(text):
    from pathlib import Path

    class Mounts(type(Path())):  # type: ignore[misc]
        def read_text(self, *_, **__):
            return text

    return Mounts


def test_rows_that_were_finished_and_are_not_seen_are_told_and_are_no_success(tmp_path, monkeypatch, capsys):
    (tmp_path / "small.toml").write_text(SMALL)
    monkeypatch.setattr(searched, "counts", lambda _: (Counter({"done": 20}), 4))
    assert run(None, Options(tmp_path / "small.toml", tmp_path / "t.h5")) == 75
    said = capsys.readouterr()
    assert said.out.startswith("20 done, 0 failed, 4 left; ")
    assert "4 rows that were reported finished are not in the table, as this node sees it" in said.err
