"""Ours and the peers side by side in one run: python -m tests.peers.bench [-o bench] [--only ours,boost] [--quick].

Prints the table and writes it as table.txt, all points as results.json, and the work-precision
diagram as work-precision.png. One core; times are processor times of both chains of a task, compilation excluded.
"""

import argparse
import json
import math
import os
import sys
from dataclasses import asdict
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"  # read when numpy is imported

from tests import measured  # noqa: E402

from . import cvode, draw, measure, octave, odeint, ours, reference, scipy_peers, table  # noqa: E402
from .common import TASKS, Missing  # noqa: E402

PEERS = {"ours": ours, "boost": odeint, "cvode": cvode, "scipy": scipy_peers, "octave": octave}
QUICK = ("A", "D")


def names_of(allowed):
    """An argparse type: names from `allowed`, separated by commas."""

    def parse(given):
        unknown = [name for name in given.split(",") if name not in allowed]
        if unknown:
            raise argparse.ArgumentTypeError(f"{', '.join(unknown)}: must be of {','.join(allowed)}")
        return given.split(",")

    return parse


def arguments(argv):
    """The command line."""
    parser = argparse.ArgumentParser(prog="bench", description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("bench"), help="folder for the results (bench)")
    parser.add_argument("--only", type=names_of(PEERS), default=list(PEERS), help=f"of {','.join(PEERS)}")
    parser.add_argument("--tasks", type=names_of(TASKS), help=f"of {','.join(TASKS)}")
    parser.add_argument("--quick", action="store_true", help="tasks A and D, fewer neighbours, a third of the budget")
    parser.add_argument("--keep", action="store_true", help="for the documentation (tests.measured)")
    given = parser.parse_args(argv)
    given.tasks = given.tasks or list(QUICK if given.quick else TASKS)
    return given


def installed(wanted):
    """The solvers that can run here, and a line per peer: its version, or why it is left out."""
    solvers, lines = [], []
    for name in wanted:
        try:
            solvers += PEERS[name].solvers()
            lines.append(f"{name}: {PEERS[name].versions()}")
        except Missing as reason:
            lines.append(f"{name}: left out, {reason}")
    return solvers, lines


def save(folder, points, header):
    """Table, points and picture."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [{**asdict(p), "error": p.error if math.isfinite(p.error) else None} for p in points]
    (folder / "table.txt").write_text(table.text(points, header))
    (folder / "results.json").write_text(json.dumps({"about": header, "points": rows}, indent=1) + "\n")
    draw.picture(points, folder / "work-precision.png", header[0])


def main(argv=None):
    """Run, print, save."""
    given = arguments(argv)
    solvers, lines = installed(given.only)
    header = [
        f"{measured.processor()}, one core of {os.cpu_count()}, load {os.getloadavg()[0]:.1f} before the run",
        *lines,
    ]
    points = measure.everything(solvers, given.tasks, reference.load(), few=given.quick)
    if not points:
        sys.exit("bench: no solver to run")
    save(given.output, points, header)
    if given.keep:
        measured.keep("peers", list(table.rows(points)), "geometric mean of the tasks in brackets, at error 1e-3")
    print((given.output / "table.txt").read_text(), end="")


if __name__ == "__main__":
    main()
