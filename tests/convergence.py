"""Every method converges: each chain alone, by the method that serves it, not certified, on random tasks.

    python -m tests.convergence [--random 500] [--seed S] [--longest 150]

Truth is Dormand-Prince at rtol 1e-11 (tests/truth.py); a few tasks are checked against scipy's DOP853. Of tasks with a
condition number below 30 the error must be at most 3 times the accuracy in 99.9 %, and never above 10 times; below 1000
its median must fall with the accuracy, and be smallest at the last. That is asked twice: of the accuracy that a caller
of kernel.ke_ratio asks for, and of the one that the steps are chosen for, which is tighter. Exit status 1 where either
does not hold. Also prints the medians behind kernel.condition.equivalent_disturbance, what ERROR_PER_ACCURACY, and
other shares of what a companion differs by, would cover, what linear chains that are run once are off by
(kernel.estimate), and what coarse steps after the first arrival change of these (kernel.arrival).
"""

import argparse
import time
from collections.abc import Callable, Mapping

import numpy as np
from scipy.integrate import DOP853

from kernel.arrival import may_be_sure
from kernel.estimate import linear_error
from kernel.ke import PARAMETERS
from kernel.lattice import PAPER_MODEL
from kernel.method import (
    COARSEST_CERTIFIED,
    EXPLICIT,
    IMPLICIT,
    METHOD_WORDS,
    SWITCH,
    Integrator,
    choose,
    looser,
    methods_of,
)
from kernel.model import make_chain
from kernel.pairs import ScaledTask, is_sure, pair_of
from kernel.status import DONE
from kernel.task import M0, V0, Task
from tests import truth
from tests.hasty import both_ways
from tests.peers import scipy_peers

ACCURACIES = 0.1 / 2.0 ** np.arange(16)  # to 3e-6
WELL, FAIR = 30.0, 1000.0
MOSTLY, NEVER, SHARE = 3.0, 10.0, 0.999  # accuracies, and the share of tasks
AGREE = 1e-6  # of the two references, where the task is well-conditioned
CERTIFIED = (1e-3, 3e-4, 3e-5)  # accuracies of runs that are certified
LATTICE = PAPER_MODEL.lattice()
Setting = Callable[[float], Integrator]
SHARES, FLOORS = (1.5, 1.0, 1 / 2, 1 / 3, 1 / 6), (0.0, 0.3, 0.5)


def asked_for(accuracy: float) -> Integrator:
    """What a caller gets who asks for this accuracy, not certified."""
    return choose(accuracy=accuracy, certify=False)


def stepped_for(accuracy: float) -> Integrator:
    """The integrator whose steps are chosen for this accuracy."""
    return choose()._replace(accuracy=accuracy)


def errors(
    tasks: Mapping[str, np.ndarray], KE: np.ndarray, accuracy: float, setting: Setting = stepped_for
) -> np.ndarray:
    """Relative, of both chains, over the accuracy, (n, 2); the methods are those that auto takes."""
    return np.abs(truth.crests(tasks, setting(accuracy)).max(axis=2) / KE - 1.0) / accuracy


def independent(tasks: Mapping[str, np.ndarray], true: truth.Truth, count: int = 8) -> float:
    """The largest disagreement with scipy's DOP853 on the shortest well-conditioned tasks."""
    ratio, well = true.KE[:, 0] / true.KE[:, 1], true.condition.max(axis=1) < WELL
    rows = [i for i in np.argsort(tasks["N"]) if well[i]][:count]
    theirs = [scipy_peers.ke_ratio(DOP853, Task(*(tasks[name][i].item() for name in PARAMETERS)), 1e-11) for i in rows]
    return float(np.max(np.abs(np.array(theirs) / ratio[rows] - 1.0)))


def judge(tasks: Mapping[str, np.ndarray], true: truth.Truth, setting: Setting) -> list[str]:
    """Print a line per chain, method and accuracy; what does not hold."""
    broken, medians, what = [], {}, setting.__name__.replace("_", " ")
    for accuracy in ACCURACIES:
        found = errors(tasks, true.KE, accuracy, setting)
        for chain, name in enumerate(truth.CHAINS):
            served = methods_of(tasks["N"], tasks["N"] * tasks["zeta_T"], chain == 1, setting(accuracy))
            for code, word in enumerate(METHOD_WORDS):
                e = found[(served == code) & (true.condition[:, chain] < WELL), chain]
                fair = found[(served == code) & (true.condition[:, chain] < FAIR), chain]
                if not len(e):
                    continue
                within, worst = float(np.mean(e <= MOSTLY)), float(np.max(e))
                medians.setdefault((name, word), []).append(float(np.median(fair)) * accuracy)
                line = (
                    f"{name:9}{word:9}{what} {accuracy:.1e}: {len(e)} tasks, {within:.2%} within 3, worst {worst:.3g}"
                )
                print(line + f"; condition below 1000: median error {medians[name, word][-1]:.1e}", flush=True)
                if within < SHARE or worst > NEVER:
                    broken.append(line)
    for (name, word), falling in medians.items():
        if len(falling) > 1 and not falling[-1] < min(falling[:-1]):
            broken.append(f"{name} {word}, {what}: the median error is not smallest at the last accuracy")
    return broken


def disturbances(tasks: Mapping[str, np.ndarray], true: truth.Truth) -> None:
    """The disturbance that a step amounts to, over the accuracy."""
    fair = (true.condition.sum(axis=1) > 20.0) & (true.condition.sum(axis=1) < FAIR)
    some = {name: values[fair] for name, values in tasks.items()}
    for accuracy in ACCURACIES[ACCURACIES <= COARSEST_CERTIFIED]:
        coarser = looser(choose()._replace(accuracy=accuracy)).accuracy
        fine, coarse = (truth.crests(some, choose()._replace(accuracy=a)) for a in (accuracy, coarser))
        size = np.median(truth.distance(fine, coarse).sum(axis=1) / true.condition[fair].sum(axis=1))
        print(f"steps of accuracy {coarser:.1e} amount to a disturbance of {size:.1e} ({fair.sum()} tasks)")


def shares(tasks: Mapping[str, np.ndarray], true: truth.Truth) -> None:
    """What an error of so great a share of the companion's difference, and of so many accuracies at least, covers."""
    ratio, calm = true.KE[:, 0] / true.KE[:, 1], true.condition.sum(axis=1) < FAIR
    for accuracy in CERTIFIED:
        run = choose()._replace(accuracy=accuracy)
        fine, coarse = (truth.crests(tasks, x) for x in (run, looser(run)))
        error = np.abs(truth.ratio(fine) / ratio - 1.0)[calm]
        difference = truth.distance(fine, coarse, margin=1.0).sum(axis=1)[calm]
        for share in SHARES:
            told = [np.maximum(share * difference, least * accuracy) for least in FLOORS]
            line = (f"{np.mean(x >= error):7.2%} {np.median(x / error):5.1f}" for x in told)
            print(f"accuracy {accuracy:.0e}, share {share:.2f}, least {FLOORS}: covered, median excess", *line)


def sure(tasks: Mapping[str, np.ndarray], true: truth.Truth) -> None:
    """What linear chains that are run once are off by, over what is stated, and how sensitive they are."""
    for accuracy in CERTIFIED:
        x, found = choose()._replace(accuracy=accuracy), []
        for i, (N, zeta_T, M, V) in enumerate(zip(*(tasks[name].tolist() for name in PARAMETERS), strict=True)):
            task = ScaledTask(N, zeta_T, M * M0, V * V0, LATTICE, ())
            linear = pair_of(task, x, np.zeros(3), False).linear
            if is_sure(task, linear):
                found.append((abs(linear.KE / true.KE[i, 1] - 1.0) / linear_error(accuracy), true.condition[i, 1]))
        off, condition = np.array(found).T
        print(
            f"accuracy {accuracy:.0e}: {len(off)} linear chains are run once, "
            f"{np.mean(off <= 1.0):.2%} within the error stated, worst {off.max():.3g} of it; "
            f"condition numbers {np.quantile(condition, 0.99):.3g} (99 %), {condition.max():.3g}"
        )


def afterwards(tasks: Mapping[str, np.ndarray]) -> None:
    """How many peaks change with coarse steps after the first arrival, and what these save."""
    light, damped = (tasks["N"] * tasks["zeta_T"] < SWITCH) == np.array([[True], [False]])
    for words, bistable, method, some in (
        ("linear chains, weak dampers", False, EXPLICIT, light),
        ("bistable chains, weak dampers", True, EXPLICIT, light),
        ("bistable chains, strong dampers", True, IMPLICIT, damped),
    ):
        for accuracy in CERTIFIED:
            work, changed = np.zeros(2), 0
            for N, zeta_T, M, V in zip(*(tasks[name][some].tolist() for name in PARAMETERS), strict=True):
                chain = make_chain(N, zeta_T, M, bistable=bistable)
                if may_be_sure(chain):
                    (fine, _), (hasty, _) = both_ways(method, chain, V * V0, accuracy)
                    changed += fine.status == DONE and hasty.speed != fine.speed
                    work += fine.site_evaluations, hasty.site_evaluations
            print(
                f"{words}, accuracy {accuracy:.0e}: coarse steps after the first arrival take "
                f"{work[1] / work[0]:.2f} of the work and change the peaks of {changed} of {some.sum()}"
            )


def main() -> int:
    """Draw, compare, tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=500, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--longest", type=int, default=150, metavar="N")
    args = parser.parse_args()
    tasks = truth.draw(args.random, args.seed, args.longest)
    soft = ~truth.stiff(tasks)
    tasks = {name: values[soft] for name, values in tasks.items()}
    true = truth.truth(tasks)
    off = independent(tasks, true)
    print(f"{len(tasks['N'])} tasks of seed {args.seed}; DOP853 is off by at most {off:.1e}")
    broken = [*judge(tasks, true, asked_for), *judge(tasks, true, stepped_for)]
    disturbances(tasks, true)
    shares(tasks, true)
    sure(tasks, true)
    afterwards(tasks)
    if off > AGREE:
        broken.append(f"the references disagree by {off:.1e}")
    print(*(f"broken: {line}" for line in broken), sep="\n")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
