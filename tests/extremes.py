"""The whole box, corners first, then random points: every task ends with finite numbers or a status that says why.

    python -m tests.extremes [--random 1000] [--accuracy 1e-3] [--certify]

Prints one line per corner, the slowest and the odd ones of the random points, and a summary; exit status 1 where a task
broke a promise: a number that is not finite, a status missing, more energy at the middle than there was.
"""

import argparse
import itertools
import math
import time
from dataclasses import dataclass

import numpy as np

import kernel
from kernel import KeRatio, Task

BOX = {"N": (2, 10_000), "zeta_T": (1e-6, 10.0), "M_over_M0": (0.01, 100.0), "V_over_V0": (0.01, 20.0)}
HEADER = f"{'N':>6} {'zeta_T':>9} {'M/M0':>8} {'V/V0':>8} {'ke_ratio':>11} {'error':>8} {'steps':>9} {'s':>8}  status"


@dataclass(frozen=True)
class Trial:
    """One task of the box and how it ended."""

    task: Task
    result: KeRatio
    seconds: float

    @property
    def broken(self) -> str:
        """Which promise does not hold."""
        r = self.result
        if r.status == "not_converged":
            return "" if math.isfinite(r.ke_ratio * r.error) else "no number"
        if r.status != "done":
            return "" if r.status and math.isnan(r.ke_ratio) else "not done, but a number"
        if not all(math.isfinite(x) and x > 0 for x in (r.ke_ratio, r.ke_bistable, r.ke_linear)):
            return "done, but not finite"
        return "more energy than there was" if max(r.ke_bistable, r.ke_linear) > 1.0 + 1e-9 else ""

    def line(self) -> str:
        """A row of the table."""
        t, r = self.task, self.result
        numbers = f"{t.N:6d} {t.zeta_T:9.3g} {t.M_over_M0:8.3g} {t.V_over_V0:8.3g} {r.ke_ratio:11.4e} {r.error:8.1e}"
        flag = " chaotic" if r.chaotic else ""
        return f"{numbers} {r.steps:9d} {self.seconds:8.3f}  {r.status}{flag} {self.broken}".rstrip()


def corners() -> list[Task]:
    """Every corner of the box, and those of zeta_T = 0."""
    zeta_T = (0.0, *BOX["zeta_T"])
    return [
        Task(int(N), z, M, V) for N, z, M, V in itertools.product(BOX["N"], zeta_T, BOX["M_over_M0"], BOX["V_over_V0"])
    ]


def random_tasks(count: int) -> list[Task]:
    """Log-uniform in the box, one in ten undamped; always the same."""
    rng = np.random.default_rng(1)
    x = np.exp([rng.uniform(np.log(a), np.log(b), count) for a, b in BOX.values()])
    x[1, rng.random(count) < 0.1] = 0.0
    return [Task(int(N), float(z), float(M), float(V)) for N, z, M, V in x.T]


def run(task: Task, accuracy: float, certify: bool) -> Trial:
    """Time one task."""
    start = time.perf_counter()
    result = kernel.ke_ratio(task.N, task.zeta_T, task.M_over_M0, task.V_over_V0, accuracy, certify=certify)
    return Trial(task, result, time.perf_counter() - start)


def main() -> int:
    """Print the tables; 1 where a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=1000)
    parser.add_argument("--accuracy", type=float, default=1e-3)
    parser.add_argument("--certify", action="store_true", help="errors too: hours, on the chaotic ones of 10 000 sites")
    args = parser.parse_args()
    how = args.accuracy, args.certify
    run(Task(2, 0.0, 1.0, 1.0), *how)  # compiles
    trials = []
    print("corners", HEADER, sep="\n")
    for task in corners():
        trials.append(run(task, *how))
        print(trials[-1].line(), flush=True)
    points = [run(task, *how) for task in random_tasks(args.random)]
    odd = [p for p in points if p.result.status != "done" or p.broken]
    print("random points: not done, or a promise broken", HEADER, *(p.line() for p in odd), sep="\n")
    slow = sorted(points, key=lambda p: -p.seconds)[:5]
    print("random points: the slowest", HEADER, *(p.line() for p in slow), sep="\n")
    trials += points
    broken = sum(bool(t.broken) for t in trials)
    done = sum(t.result.status == "done" for t in trials)
    checked = any(t.result.checked for t in trials)
    chaotic = f"{sum(bool(t.result.chaotic) for t in trials)} chaotic" if checked else "not checked for chaos"
    print(f"{len(trials)} tasks: {done} done ({chaotic}), {len(trials) - done} with a reason, {broken} broken promises")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
