"""Two ranks against one process on the same sweep, and what waiting and messages cost.

    python -m tests.scaling [--pairs 5] [--spec SPEC]

Pairs alternate, so that both see the same machine. Per pair: the ratio of the wall times with and without starting the
processes, the share of the time in which the ranks computed, core seconds while waiting, and those of rank 0's serving.
Other programs on the machine can only lower the ratios: the best pair is the claim.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sweep.store import table

ROOT = Path(__file__).parent.parent
BIN = Path(sys.executable).parent
LIMIT = 1200  # seconds of one run: a deadlock ends too
SPEC = """
name = "scaling"
[grid]
N         = { linear = [100, 300], points = 51 }
zeta_T    = [0.0, 1e-4, 1e-3, 1e-2]
M_over_M0 = [0.5, 2]
V_over_V0 = [0.3, 1, 3]
[accuracy]
target = 1e-4
"""


class Run(NamedTuple):
    """One run of the sweep."""

    wall: float  # seconds, from the command to its end
    loop: float  # from the first batch to the last row
    cpu: float  # core seconds of all processes
    row: np.void  # of the table's list of runs


def run(spec: Path, ranks: int, folder: Path) -> Run:
    """The sweep into a new table."""
    path = folder / f"{ranks}.h5"
    path.unlink(missing_ok=True)
    launcher = [str(BIN / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
    start, before = time.perf_counter(), _cpu()
    command = [*launcher, str(BIN / "sweep"), "run", str(spec), "-o", str(path)]
    done = subprocess.run(command, capture_output=True, cwd=folder, text=True, timeout=LIMIT)
    if done.returncode not in (0, 1):  # 1: some tasks do not reach their target
        raise SystemExit(done.stderr)
    wall, cpu = time.perf_counter() - start, _cpu() - before
    with table.reading(path) as file:
        row = table.runs(file)[-1]
    return Run(wall, float(row["busy"] / (row["busy_share"] * row["ranks"])), cpu, row)


def _cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Print a line per pair, then the best."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--spec", type=Path)
    args, best = parser.parse_args(), (0.0, 0.0)
    print("pair  wall x  loop x  busy share  cpu x   waited  of a core  serving  requests   tail  load")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        spec = args.spec.resolve() if args.spec else folder / "scaling.toml"
        if not args.spec:
            spec.write_text(SPEC)
        for pair in range(args.pairs):
            one, two = run(spec, 1, folder), run(spec, 2, folder)
            row, ratios = two.row, (one.wall / two.wall, one.loop / two.loop)
            best = max(best[0], ratios[0]), max(best[1], ratios[1])
            print(
                f"{pair:4} {ratios[0]:7.2f} {ratios[1]:7.2f} {row['busy_share']:11.1%} {two.cpu / one.cpu:6.2f} "
                f"{row['waited'] / (2 * two.loop):8.2%} {row['waited_cpu'] / max(1e-9, row['waited']):10.1%} "
                f"{row['serving'] / two.loop:8.2%} {row['requests']:9} {row['tail']:6.3f} {os.getloadavg()[0]:5.1f}",
                flush=True,
            )
    print(f"best: {best[0]:.2f} times one process with starting, {best[1]:.2f} without")


if __name__ == "__main__":
    main()
