"""The one converged reference, kept in reference.json: rk45 at rtol 1e-11, checked once against scipy's DOP853.

Judged are the first neighbours of each task whose ratio is determined by the inputs: rk45 at rtol 1e-11 and 1e-9 agree
to 1e-5. A chaotic neighbour tells nothing about a solver. `python -m tests.peers.reference` computes all anew.
"""

import json
import sys
from pathlib import Path

import scipy.integrate

import kernel

from . import scipy_peers
from .common import TASKS, neighbours

STORE = Path(__file__).with_name("reference.json")
RTOL, LOOSER, AGREE = 1e-11, 1e-9, 1e-5
CHECK_RTOL = 1e-12  # of DOP853, on the task itself
JUDGED = {"E": 5}  # tasks with fewer than the usual 16
USUAL = 16


def converged(task, rtol=RTOL):
    """ke_ratio by rk45."""
    return kernel.ke_ratio(**vars(task), method="rk45", rtol=rtol, certify=False).ke_ratio


def judged_of(name):
    """[[index among the neighbours, ke_ratio], ...] of those that are judged."""
    rows = []
    for index, task in enumerate(neighbours(name)):
        exact = converged(task)
        if abs(converged(task, LOOSER) / exact - 1.0) <= AGREE:
            rows.append([index, exact])
        if len(rows) == JUDGED.get(name, USUAL):
            break
    return rows


def check(name, exact):
    """How far scipy's DOP853 at a tight tolerance is from it."""
    return abs(scipy_peers.ke_ratio(scipy.integrate.DOP853, TASKS[name], CHECK_RTOL) / exact - 1.0)


def compute(path=STORE):
    """Write the reference of every task."""
    table = {}
    for name in TASKS:
        rows = judged_of(name)
        table[name] = {"judged": rows, "off_DOP853": check(name, dict(rows)[0])}
        print(f"{name}: {len(rows)} judged, DOP853 is off by {table[name]['off_DOP853']:.1e}", flush=True)
    path.write_text(json.dumps(table, indent=1) + "\n")


def load(path=STORE):
    """{task: {index of the neighbour: ke_ratio}}."""
    return {name: dict(entry["judged"]) for name, entry in json.loads(path.read_text()).items()}


if __name__ == "__main__":
    sys.exit(compute())
