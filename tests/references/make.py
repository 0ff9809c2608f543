"""Make reference tasks: two independent methods that agree, with a condition number.

    python -m tests.references.make -o tests/data/references.csv [--count 240 --stiff 24 --chaotic 36]
    python -m tests.references.make -o tests/data/references.csv --judge

Three lists, one after the other: random tasks over the paper's domain and beyond; stiff ones, long chains with zeta_T
above 0.5; chaotic ones. ke_ratio by our Dormand-Prince 5(4) at rtol 1e-11 and, in the column dop853, by scipy's DOP853
at rtol 1e-12, of a stiff task by CVODE's BDF (scikit-sundae). The condition number is that of tests.truth, and `shown`
what of it a disturbed run shows; stiff tasks have none to speak of. --judge makes these two anew, after crests are
compared otherwise. Rows are appended one by one, so the program can be stopped and started again.
"""

import argparse
import csv
from collections.abc import Callable, Iterator
from itertools import chain, islice
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853

import kernel
from kernel.columns import KeRatio
from kernel.condition import CHAOTIC
from kernel.task import Task
from tests import truth
from tests.peers import cvode, scipy_peers

RTOL, ATOL = 1e-11, 1e-14
STEP = 1e-6
STIFFEST = 30_000  # N zeta: beyond it an explicit method of order 8 needs minutes
# Tasks for the chaotic list are looked for by rk45 at this rtol, on chains for which DOP853 needs seconds, below the
# highest speed, which has no faster neighbour.
SEEK_RTOL, LONGEST_CHAOTIC, FASTEST = 1e-9, 130, 19.0
NAMES = ("N", "zeta_T", "M_over_M0", "V_over_V0")
PARTS = ("ke_bistable", "ke_linear", "ke_ratio", "t_peak_bistable", "t_peak_linear")
COLUMNS = (*NAMES, *PARTS, "dop853", "disagreement", "condition", "shown")


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Three digits are enough, and short in the file."""
    return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.3g}")


def draw(rng: np.random.Generator) -> Task:
    """Three in four from the paper's domain, the others from a wider box; one in eight undamped."""
    wide = rng.random() < 0.25
    N = int(np.rint(np.exp(rng.uniform(np.log(2 if wide else 5), np.log(1000 if wide else 500)))))
    impact = (0.03, 30.0) if wide else (0.1, 10.0)
    M, V = (log_uniform(rng, *impact) for _ in range(2))
    zeta_T = log_uniform(rng, 1e-5, 1.0) if rng.random() > 0.125 else 0.0
    return Task(N, zeta_T, M, min(V, 20.0))


def random_tasks() -> Iterator[Task]:
    """What an explicit method can afford; always the same ones."""
    rng = np.random.default_rng(20261120)
    while True:
        task = draw(rng)
        if task.N**2 * task.zeta_T <= STIFFEST:
            yield task


def stiff_tasks() -> Iterator[Task]:
    """Of the paper's domain, and its corner."""
    rng = np.random.default_rng(20261121)
    yield Task(500, 1.0, 1.0, 10.0)
    while True:
        N, zeta_T = int(log_uniform(rng, 200, 500)), log_uniform(rng, 0.5, 1.0)
        yield Task(N, zeta_T, log_uniform(rng, 0.1, 10.0), log_uniform(rng, 0.1, 10.0))


def chaotic_tasks() -> Iterator[Task]:
    """Random tasks whose neighbours differ; half of the bound is asked, as the search is not the last word."""
    rng = np.random.default_rng(20261122)
    while True:
        task = draw(rng)
        affordable = task.N <= LONGEST_CHAOTIC and task.V_over_V0 <= FASTEST and task.N**2 * task.zeta_T <= STIFFEST
        if affordable and condition(lambda t: ours(t, SEEK_RTOL).ke_ratio, task) > 0.5 * CHAOTIC:
            yield task


def ours(task: Task, rtol: float = RTOL) -> KeRatio:
    """Our converged result."""
    return kernel.ke_ratio(*values(task), method="rk45", rtol=rtol, atol=ATOL / RTOL * rtol, certify=False)


def by_dop853(task: Task) -> float:
    """The second method."""
    return scipy_peers.ke_ratio(DOP853, task, 1e-12)


def by_bdf(task: Task) -> float:
    """The second method of a stiff task."""
    return cvode.ke_ratio("BDF", task, RTOL)


def values(task: Task) -> tuple[int, float, float, float]:
    """In the order of NAMES."""
    return task.N, task.zeta_T, task.M_over_M0, task.V_over_V0


def condition(ratio: Callable[[Task], float], task: Task) -> float:
    """|d ln ke_ratio / d ln V|, the larger one of both sides."""
    N, zeta_T, M, V = values(task)
    here, *sides = (ratio(Task(N, zeta_T, M, V * (1.0 + side * STEP))) for side in (0, -1, 1))
    return max(abs(side / here - 1.0) for side in sides) / STEP


def judged(task: Task, stiff: bool) -> dict[str, float]:
    """How sensitive it is."""
    if stiff:
        return {"condition": 1.0, "shown": 0.0}
    found = truth.truth_here({name: np.array([value]) for name, value in zip(NAMES, values(task), strict=True)})
    return {"condition": float(found.condition.sum()), "shown": float(found.shown[0])}


def row(task: Task, second: Callable[[Task], float]) -> dict[str, float]:
    """One reference."""
    first, other = ours(task), second(task)
    return (
        {name: getattr(task, name) for name in NAMES}
        | {name: getattr(first, name) for name in PARTS}
        | {"dop853": other, "disagreement": abs(other / first.ke_ratio - 1.0)}
        | judged(task, second is by_bdf)
    )


def rows(count: int, stiff: int, chaotic: int, done: int) -> Iterator[dict[str, float]]:
    """The three lists without the first `done` rows."""
    lists = ((random_tasks(), count, by_dop853), (stiff_tasks(), stiff, by_bdf), (chaotic_tasks(), chaotic, by_dop853))
    wanted = chain.from_iterable(((task, second) for task in islice(tasks, n)) for tasks, n, second in lists)
    for task, second in islice(wanted, done, None):
        yield row(task, second)


def judge_again(path: Path, stiff: range) -> None:
    """The columns `condition` and `shown` of a file that is there; stiff: numbers of its stiff rows."""
    with path.open(newline="") as file:
        there = list(csv.DictReader(file))
    for i, one in enumerate(there):
        task = Task(int(one["N"]), *(float(one[name]) for name in NAMES[1:]))
        one |= {name: str(value) for name, value in judged(task, i in stiff).items()}
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(there)


def main() -> None:
    """Append what is missing."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    for name, count in (("count", 240), ("stiff", 24), ("chaotic", 36)):
        parser.add_argument(f"--{name}", type=int, default=count)
    parser.add_argument("--judge", action="store_true", help="only how sensitive the rows are that are there")
    args = parser.parse_args()
    if args.judge:
        judge_again(args.output, range(args.count, args.count + args.stiff))
        return
    done = len(args.output.read_text().splitlines()) - 1 if args.output.exists() else -1
    with args.output.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if done < 0:
            writer.writeheader()
        for reference in rows(args.count, args.stiff, args.chaotic, max(0, done)):
            writer.writerow(reference)
            file.flush()


if __name__ == "__main__":
    main()
