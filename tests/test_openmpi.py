"""Open MPI, in an environment of its own (make openmpi), gives the bits of the MPI that the other tests use."""

import signal
import subprocess
import time
from pathlib import Path

import pytest

from sweep.errors import InputError
from sweep.tell import report

from .conftest import BIN, TIME_LIMIT, clean_environment

OTHER = BIN.parent.with_name(".venv-openmpi") / "bin"
pytestmark = [
    pytest.mark.mpi,
    pytest.mark.skipif(not (OTHER / "sweep").exists(), reason="no .venv-openmpi: make openmpi builds it"),
]
# As root, and with more ranks than cores, Open MPI wants to be told that this is meant.
MEANT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "true",
    "OMPI_MCA_mpi_yield_when_idle": "true",
}


@pytest.fixture
def other(tmp_path):
    """other(*arguments, ranks): starts `sweep` of the Open MPI environment in tmp_path; killed when the test ends."""
    started: list[subprocess.Popen[str]] = []

    def start(*arguments: object, ranks: int) -> "subprocess.Popen[str]":
        command = [OTHER / "mpirun", "-n", str(ranks), OTHER / "sweep", *map(str, arguments)]
        pipe, env = subprocess.PIPE, clean_environment() | MEANT
        started.append(subprocess.Popen(command, cwd=tmp_path, env=env, stdout=pipe, stderr=pipe, text=True))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.communicate(timeout=TIME_LIMIT)


@pytest.mark.parametrize(("ranks", "writer"), [(2, "gather"), (3, "mpio")])
def test_open_mpi_gives_the_same_bits(sweep, other, small_spec, tmp_path, physics, ranks, writer):
    process = other("run", small_spec, "-o", "t.h5", "--writer", writer, ranks=ranks)
    out, err = process.communicate(timeout=TIME_LIMIT)
    assert process.returncode == 0, err
    assert out.startswith("24 done, 0 failed, 0 left")
    assert f"; {ranks} ranks, " in err
    assert report.show(tmp_path / "t.h5")["versions"]["MPI"].startswith("Open MPI")
    sweep("run", small_spec, "-o", "ours.h5", ranks=2)
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "ours.h5")


def test_open_mpi_stops_at_a_signal_and_the_other_mpi_goes_on(sweep, other, slow_spec, tmp_path):
    process = other("run", slow_spec, "-o", "t.h5", ranks=2)
    until = time.monotonic() + TIME_LIMIT
    while not done(tmp_path / "t.h5"):
        assert process.poll() is None and time.monotonic() < until, process.communicate()
        time.sleep(0.05)
    process.send_signal(signal.SIGUSR1)
    _, err = process.communicate(timeout=TIME_LIMIT)
    assert process.returncode == 75, err
    before = done(tmp_path / "t.h5")
    assert 0 < before < 492
    again = sweep("run", slow_spec, "-o", "t.h5", ranks=2)
    assert again.returncode == 0
    assert f"492 tasks, {492 - before} left; " in again.stderr


def done(path: Path) -> int:
    """Finished rows so far."""
    try:
        return int(report.status(path)["done"])
    except InputError:
        return 0


def test_the_launcher_of_the_other_mpi_is_refused(small_spec, tmp_path):
    command = [OTHER / "mpirun", "-n", "2", BIN / "sweep", "run", small_spec, "-o", "t.h5"]
    env = clean_environment() | MEANT
    answer = subprocess.run(command, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=TIME_LIMIT)
    assert answer.returncode == 2
    assert "OMPI_COMM_WORLD_SIZE=2, but MPI sees one process" in answer.stderr
    assert not (tmp_path / "t.h5").exists()
