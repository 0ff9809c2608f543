"""Octave's ode45: the closest free stand-in for the MATLAB ode45 of the paper. One process, times taken inside it."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from kernel.task import T_END_OVER_N

from .common import ATOL_OVER_RTOL, Missing, Solver, parameters

SOURCE = Path(__file__).with_name("ke.m")


def command():
    """The interpreter without a screen; Missing where it is not installed."""
    found = shutil.which("octave-cli") or shutil.which("octave")
    if found is None:
        raise Missing("octave is not installed")
    return [found, "--norc", "--no-history", "--no-gui", "--quiet"]


def row(task, rtol):
    """What ke.m reads for one task."""
    zeta, c2, c3, K, mass, V = parameters(task, bistable=True)
    return [task.N, zeta, K, mass, V, c2, c3, T_END_OVER_N * task.N, rtol, ATOL_OVER_RTOL * rtol]


def run(tasks, rtol):
    """Ratios and seconds per task."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rows.txt"
        np.savetxt(path, [row(task, rtol) for task in tasks], fmt="%.17g")
        done = subprocess.run(
            [*command(), str(SOURCE), str(path)],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )
    if done.returncode:
        raise RuntimeError(f"octave: {done.stderr.strip()}")
    bistable, linear, seconds = np.array([line.split() for line in done.stdout.splitlines()], dtype=float).T
    return (bistable / linear) ** 2, float(np.mean(seconds))


def solvers():
    """Loose tolerances on the task itself only: it is a thousand times slower than compiled code."""
    command()
    return [Solver("Octave ode45", (1e-3, 1e-4, 1e-5, 1e-6), run, judged=1, budget=40.0, longest=300)]


def versions():
    """What ran."""
    return subprocess.run([*command(), "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
