"""Make reference tasks: two independent methods that agree, with a condition number.

    python -m tests.references.make -o tests/data/references.csv --count 240

Random tasks over the paper's domain and beyond. ke_ratio by our Dormand-Prince 5(4) at rtol 1e-11 and by scipy's DOP853
at rtol 1e-12; the condition number is |d ln ke_ratio / d ln V| over a relative change of 1e-6 either way. Rows are
appended one by one, so the program can be stopped and started again.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853

import kernel
from kernel.ke import KeRatio
from kernel.task import Task
from tests.peers.scipy_peers import ke_ratio

RTOL, ATOL = 1e-11, 1e-14
STEP = 1e-6
STIFFEST = 30_000  # N zeta: beyond it an explicit method of order 8 needs minutes
NAMES = ("N", "zeta_T", "M_over_M0", "V_over_V0")
PARTS = ("ke_bistable", "ke_linear", "ke_ratio", "t_peak_bistable", "t_peak_linear")


def draw(rng: np.random.Generator) -> Task:
    """Three in four from the paper's domain, the others from a wider box; one in eight undamped."""
    wide = rng.random() < 0.25
    N = int(np.rint(np.exp(rng.uniform(np.log(2 if wide else 5), np.log(1000 if wide else 500)))))
    impact = (0.03, 30.0) if wide else (0.1, 10.0)
    M, V = (float(f"{np.exp(rng.uniform(*np.log(impact))):.3g}") for _ in range(2))
    zeta_T = float(f"{np.exp(rng.uniform(np.log(1e-5), 0.0)):.3g}") if rng.random() > 0.125 else 0.0
    return Task(N, zeta_T, M, min(V, 20.0))


def tasks(count: int) -> list[Task]:
    """The first `count` tasks that an explicit method can afford; always the same."""
    rng, found = np.random.default_rng(20261120), []
    while len(found) < count:
        task = draw(rng)
        if task.N**2 * task.zeta_T <= STIFFEST:
            found.append(task)
    return found


def tight(task: Task, factor: float = 1.0) -> KeRatio:
    """Our converged result, V scaled by `factor`."""
    V = task.V_over_V0 * factor
    return kernel.ke_ratio(task.N, task.zeta_T, task.M_over_M0, V, method="rk45", rtol=RTOL, atol=ATOL, certify=False)


def row(task: Task) -> dict[str, float]:
    """One reference."""
    ours, theirs = tight(task), ke_ratio(DOP853, task, 1e-12)
    sides = [tight(task, 1.0 + side * STEP).ke_ratio for side in (-1, 1)]
    condition = max(abs(side / ours.ke_ratio - 1.0) for side in sides) / STEP
    return (
        {name: getattr(task, name) for name in NAMES}
        | {name: getattr(ours, name) for name in PARTS}
        | {"dop853": theirs, "disagreement": abs(theirs / ours.ke_ratio - 1.0), "condition": condition}
    )


def main() -> None:
    """Append what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--count", type=int, default=240)
    args = parser.parse_args()
    done = len(args.output.read_text().splitlines()) - 1 if args.output.exists() else -1
    with args.output.open("a", newline="") as file:
        writer = csv.DictWriter(file, [*NAMES, *PARTS, "dop853", "disagreement", "condition"])
        if done < 0:
            writer.writeheader()
        for task in tasks(args.count)[max(0, done) :]:
            writer.writerow(row(task))
            file.flush()


if __name__ == "__main__":
    main()
