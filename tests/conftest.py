"""Fixtures shared by all tests. Everything that starts a process has a time limit: a deadlock is a failure."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

BIN = Path(sys.executable).parent
TIME_LIMIT = 240  # seconds; far above what any command here takes
# mpirun must not think that it runs inside another job, and one rank must not take the other's core.
LAUNCHER_VARIABLES = ("PMI_", "PMIX_", "OMPI_", "SLURM_", "HYDRA_", "MPI_")

Run = Callable[..., "subprocess.CompletedProcess[str]"]

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


def clean_environment() -> dict[str, str]:
    """The environment without the traces of any launcher."""
    return {k: v for k, v in os.environ.items() if not k.startswith(LAUNCHER_VARIABLES)}


@pytest.fixture
def environment() -> dict[str, str]:
    """A copy to change at will."""
    return clean_environment()


@pytest.fixture
def sweep(tmp_path: Path) -> Run:
    """sweep(*arguments, ranks=1, env=...): the installed console script, in tmp_path, under mpirun if ranks > 1."""

    def run(*arguments: object, ranks: int = 1, env: dict[str, str] | None = None) -> "subprocess.CompletedProcess[str]":
        launcher = [str(BIN / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
        command = [*launcher, str(BIN / "sweep"), *map(str, arguments)]
        return subprocess.run(
            command, cwd=tmp_path, env=env or clean_environment(), capture_output=True, text=True, timeout=TIME_LIMIT
        )

    return run


@pytest.fixture
def small_spec(tmp_path: Path) -> Path:
    """A sweep of 24 tasks that takes well under a second."""
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture(scope="session")
def reference() -> list[dict[str, float]]:
    """Converged tasks with their condition number."""
    path = Path(__file__).parent / "data" / "reference.json"
    cases: list[dict[str, float]] = json.loads(path.read_text())
    return cases
