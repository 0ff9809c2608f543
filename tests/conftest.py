"""Fixtures shared by all tests. Everything that starts a process has a time limit: a deadlock is a failure."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import pytest
from hypothesis import settings

from sweep.errors import InputError
from sweep.store import table
from tests import browser, shared_memory
from tests.forked import Forks

# How long an example takes is the machine's business.
settings.register_profile("no deadline", deadline=None)
settings.load_profile("no deadline")

BIN = Path(sys.executable).parent
TIME_LIMIT = 240  # seconds; far above what any command here takes
# mpirun must not think that it runs inside another job, and one rank must not take the other's core.
LAUNCHER_VARIABLES = ("PMI_", "PMIX_", "OMPI_", "SLURM_", "HYDRA_", "MPI_")

RUN_COLUMNS = ("seconds", "rank", "checksum")  # the only ones that may differ between two runs of one spec

Run = Callable[..., "subprocess.CompletedProcess[str]"]
Start = Callable[..., "subprocess.Popen[str]"]

SMALL = """
name = "small"
[grid]
N         = [5, 8, 13]
zeta_T    = [0.0, 1e-3]
M_over_M0 = [0.5, 2]
V_over_V0 = { log = [0.3, 3], points = 2 }
[accuracy]
target = 1e-2
"""


SLOW = """
name = "slow"
[grid]
N         = { linear = [60, 160], points = 41 }
zeta_T    = [1e-4, 1e-3]
M_over_M0 = [0.5, 2]
V_over_V0 = [0.3, 1, 3]
[accuracy]
method = "rk45"
rtol = 1e-7
"""


# The files whose tests take longest (pytest --durations): they begin first, lest one of them be left at the end.
LONG = ("newcomer", "sweep_chaos", "nodes", "kernel_chains", "sweep_lowest", "slurm", "kernel_simulation", "readme")
LONG += ("sweep_kill", "sweep_join", "sweep_stop", "sweep_run_mpi", "sweep_bad_days", "kernel_certify")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what is slow: a test that starts commands waits for an interpreter each time. The long files come first."""
    for item in items:
        if {"sweep", "start", "environment"} & set(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.slow)
    place = {f"test_{name}": k for k, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.path.stem, len(LONG)))


def clean_environment() -> dict[str, str]:
    """The environment without the traces of any launcher; Python keeps what it prints in its buffer, as for users."""
    return {k: v for k, v in os.environ.items() if not k.startswith((*LAUNCHER_VARIABLES, "PYTHONUNBUFFERED"))}


def problems_of(call: Callable[..., Any], *arguments: object, **named: object) -> tuple[str, ...]:
    """The lines with which what is called refuses these arguments."""
    with pytest.raises(InputError) as caught:
        call(*arguments, **named)
    return caught.value.problems


def rows_of(path: Path, name: str = "results") -> Any:
    """The rows of a table, or what another of its datasets holds."""
    with table.reading(path) as file:
        return file[name][()]


@contextlib.contextmanager
def changed(path: Path, name: str = "results") -> Iterator[Any]:
    """The same, written back as the block has changed it."""
    with h5py.File(path, "r+") as file:
        rows = file[name][()]
        yield rows
        file[name][...] = rows


@pytest.fixture
def environment() -> dict[str, str]:
    """A copy to change at will."""
    return clean_environment()


@pytest.fixture(scope="session")
def forks() -> Iterator[Forks]:
    """What single processes are forked off."""
    forks = Forks(clean_environment())
    yield forks
    forks.server.communicate(timeout=TIME_LIMIT)


@pytest.fixture
def sweep(tmp_path: Path, forks: Forks) -> Run:
    """sweep(*arguments, ranks=1, env=...): the installed console script, in tmp_path, under mpirun if ranks > 1."""

    def run(
        *arguments: object, ranks: int = 1, env: dict[str, str] | None = None
    ) -> "subprocess.CompletedProcess[str]":
        launcher = [str(BIN / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
        command = [*launcher, str(BIN / "sweep"), *map(str, arguments)]
        if ranks == 1 and env is None:
            return forks.run(command, tmp_path, TIME_LIMIT)
        return subprocess.run(
            command, cwd=tmp_path, env=env or clean_environment(), capture_output=True, text=True, timeout=TIME_LIMIT
        )

    return run


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """start(*arguments, ranks=1): the same without waiting, in its own process group, killed when the test ends."""
    started: list[subprocess.Popen[str]] = []

    def launch(*arguments: object, ranks: int = 1) -> "subprocess.Popen[str]":
        launcher = [str(BIN / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
        command = [*launcher, str(BIN / "sweep"), *map(str, arguments)]
        pipe, env = subprocess.PIPE, clean_environment()
        started.append(
            subprocess.Popen(
                command, cwd=tmp_path, env=env, stdout=pipe, stderr=pipe, text=True, start_new_session=True
            )
        )
        return started[-1]

    with shared_memory.cleared():
        yield launch
        for process in started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.communicate(timeout=TIME_LIMIT)


@pytest.fixture(scope="module")
def running() -> Iterator[Any]:
    """A browser, for all tests of a file."""
    with browser.browser() as found:
        yield found


@pytest.fixture
def unprivileged(tmp_path: Path) -> Run:
    """unprivileged(*arguments): sweep as a process that permissions bind, also where the tests run as root."""
    drop = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"] if os.getuid() == 0 else []

    def run(*arguments: object) -> "subprocess.CompletedProcess[str]":
        command, env = [*drop, str(BIN / "sweep"), *map(str, arguments)], clean_environment()
        return subprocess.run(command, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=TIME_LIMIT)

    return run


@pytest.fixture
def slow_spec(tmp_path: Path) -> Path:
    """A sweep of 492 tasks that takes some seconds, so that it can be stopped half-way."""
    path = tmp_path / "slow.toml"
    path.write_text(SLOW)
    return path


@pytest.fixture
def physics() -> Callable[[Path], dict[str, bytes]]:
    """physics(table): the bits of every column that must not depend on how the table was computed."""

    def bits(table: Path) -> dict[str, bytes]:
        with h5py.File(table, "r") as file:
            rows = file["results"][()]
        return {name: rows[name].tobytes() for name in rows.dtype.names if name not in RUN_COLUMNS}

    return bits


@pytest.fixture
def small_spec(tmp_path: Path) -> Path:
    """A sweep of 24 tasks that takes well under a second."""
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture
def planned() -> Callable[[Path], dict[str, Any]]:
    """planned(spec): what `sweep plan` tells."""
    from sweep.plan.spec import read_spec
    from sweep.tell import report

    return lambda path: report.plan(*read_spec(path), path.parent)


@pytest.fixture(scope="session")
def reference() -> list[dict[str, float]]:
    """Converged tasks with their condition number."""
    path = Path(__file__).parent / "data" / "reference.json"
    cases: list[dict[str, float]] = json.loads(path.read_text())
    return cases
