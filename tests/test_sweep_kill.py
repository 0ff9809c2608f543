"""A sweep that is killed keeps its finished rows; resumed, it ends in the table of a sweep that was not."""

import contextlib
import os
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest

from sweep.store import table
from sweep.tell import report

from .waiting import wait_for_rows, wait_for_the_lock

pytestmark = pytest.mark.mpi
WRITERS = ("mpio", "gather") if h5py.get_config().mpi else ("gather",)


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Where the uninterrupted table is kept from one test to the next."""
    return tmp_path_factory.mktemp("reference") / "whole.h5"


def kept(path) -> tuple[np.ndarray, np.ndarray]:
    with table.reading(path) as file:
        return np.flatnonzero(table.finished(file)), file["results"][()]


@pytest.mark.parametrize(("ranks", "writer"), [(1, "gather"), *((3, writer) for writer in WRITERS)])
def test_a_killed_sweep_resumes_to_the_uninterrupted_table(
    sweep, start, slow_spec, tmp_path, physics, reference, ranks, writer
):
    if not reference.exists():
        assert sweep("run", slow_spec, "-o", reference, ranks=2).returncode == 0
    process = start("run", slow_spec, "-o", "t.h5", "--writer", writer, ranks=ranks)
    wait_for_rows(tmp_path / "t.h5", process, 20)
    os.killpg(process.pid, signal.SIGKILL)
    assert process.wait(60) == -signal.SIGKILL
    wait_for_the_lock(tmp_path / "t.h5")
    ids, before = kept(tmp_path / "t.h5")
    assert 0 < len(ids) < len(before)

    again = sweep("run", slow_spec, "-o", "t.h5", "--writer", writer, ranks=ranks)
    assert again.returncode == 0
    assert f"{len(before)} tasks, {len(before) - len(ids)} left; " in again.stderr
    _, after = kept(tmp_path / "t.h5")
    assert after[ids].tobytes() == before[ids].tobytes()
    assert physics(tmp_path / "t.h5") == physics(reference)


def test_a_run_that_loses_one_rank_ends_and_keeps_its_rows(sweep, start, slow_spec, tmp_path):
    process = start("run", slow_spec, "-o", "t.h5", ranks=2)
    done = wait_for_rows(tmp_path / "t.h5", process, 20)
    victim = _ranks_of(process.pid)[-1]
    os.kill(victim, signal.SIGKILL)
    assert process.wait(60) != 0
    assert report.status(tmp_path / "t.h5")["done"] >= done
    assert sweep("run", slow_spec, "-o", "t.h5", ranks=2).returncode == 0


def _ranks_of(launcher: int) -> list[int]:
    """The processes under mpirun that run sweep; a proxy lies between."""
    children: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
            children.setdefault(parent, []).append(int(stat.parent.name))
    return [rank for proxy in children[launcher] for rank in children[proxy]]


def test_a_link_to_a_table_that_is_not_there_yet_stays_a_link(sweep, small_spec, tmp_path):
    (tmp_path / "scratch").mkdir()
    (tmp_path / "link.h5").symlink_to("scratch/t.h5")
    assert sweep("run", small_spec, "-o", "link.h5").returncode == 0
    assert (tmp_path / "link.h5").is_symlink()
    assert report.status(tmp_path / "scratch/t.h5")["done"] == 24


def test_one_table_takes_one_run_at_a_time(sweep, start, slow_spec, tmp_path):
    process = start("run", slow_spec, "-o", "t.h5", ranks=2)
    wait_for_rows(tmp_path / "t.h5", process, 1)
    (tmp_path / "link.h5").symlink_to("t.h5")
    ranks = _ranks_of(process.pid)
    for rank in ranks:  # so that the run outlasts two starts of others, however slow these are
        os.kill(rank, signal.SIGSTOP)
    try:
        for name in ("t.h5", "link.h5"):
            second = sweep("run", slow_spec, "-o", name)
            assert second.returncode == 2
            said = "another run is writing this table; wait for it, help it by `sweep join`, or stop it"
            assert second.stderr == f"sweep: {name}: {said}\n"
    finally:
        for rank in ranks:
            os.kill(rank, signal.SIGCONT)
