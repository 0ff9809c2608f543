"""What each part of certification costs and what it catches, on random tasks.

    python -m tests.parts [--random 600] [--seed S] [--longest 150] [--targets 1e-1 1e-2 1e-3 1e-4 1e-5]

Per target a line for each part of kernel.certify: the first run, which tasks are spared whose looser run shows chaos,
the companion, the third run of those that may agree by chance, the disturbed runs that measure the condition number,
and the rest, which is one more run of chaotic tasks and the refinements of others. Cost: processor time over that of a
plain run at the same target (certify = false). Caught: of the well-conditioned tasks whose first run is beyond its
target those whose error says so; of the chaotic ones those that a measured condition number flags; what is still beyond
the target, unflagged, at the end; of the spreads those that hold the converged value, and that would if they were
widened by another factor.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from kernel.certify import WIDENED_AT_MOST, Verdict, certify, widened
from kernel.condition import CHAOTIC, MEASURED_AGAIN_TO, condition_of, seen_early
from kernel.estimate import COARSE, error_by_third, error_of, may_agree_by_chance
from kernel.extrapolate import extrapolated, first_of, plain_pair
from kernel.ke import PARAMETERS
from kernel.lattice import PAPER_MODEL
from kernel.method import FINEST_SPLITTING, Integrator, choose, looser
from kernel.pairs import Pair, Rung, ScaledTask, bistable_peak, completed, pair_of
from kernel.task import M0, V0
from tests import promises
from tests.measured import keep

LATTICE = PAPER_MODEL.lattice()
FACTORS = (1.0, 1.35, 1.5, 1.65, WIDENED_AT_MOST, 2.2)


class Seen(NamedTuple):
    """One task: seconds of each part, and what it told."""

    seconds: tuple[float, float, float, float, float, float]  # plain, first run, companion, third, disturbed, rest
    first: Pair  # with the companion, where the two are extrapolated
    error: float  # of the first run, as the companion tells it
    third: float  # the same, as a third run tells it where one is asked
    asked: bool  # a third run
    measured: bool
    verdict: Verdict


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Processor seconds and the result."""
    start = time.thread_time()
    result = work()
    return time.thread_time() - start, result


def see(task: ScaledTask, certified: Integrator, plain: Integrator) -> Seen:
    """Take certification apart, as kernel.certify.certify puts it together for "auto"."""
    work, certified = np.zeros(3), first_of(task, certified)
    loose = looser(certified)
    bare, _ = timed(lambda: plain_pair(task, 0.0, plain, work, False))
    again, _ = timed(lambda: bistable_peak(task, 0.0, 0.0, loose, work, False))
    before, early = timed(lambda: seen_early(task, loose, work))
    once, first = timed(lambda: pair_of(task, certified, work, False))
    besides, companion = timed(lambda: completed(task, first, early.run, 0.0, loose, work, False))
    rung = Rung(first, certified, companion, loose)
    doubtful, third, more = may_agree_by_chance(task, rung), 0.0, 0.0
    alone = error_of(task, rung)
    if early.condition >= MEASURED_AGAIN_TO:
        once, later, was_measured = 0.0, 0.0, True
    else:
        if doubtful and alone <= certified.target and certified.accuracy <= COARSE:
            more, third = timed(lambda: error_by_third(task, rung, work))
        later, seen = timed(lambda: condition_of(task, rung, doubtful, early, work))
        was_measured = bool(np.isfinite(seen.near))
    whole, verdict = timed(lambda: certify(task, certified, work))
    again, disturbed = again + besides, max(0.0, before - again) + later
    rest = max(0.0, whole - once - again - more - disturbed)
    seconds = (bare, once, again, more, disturbed, rest)
    return Seen(seconds, extrapolated(task, rung), alone, max(alone, third), more > 0.0, was_measured, verdict)


def holds(spread: Verdict, true: float, factor: float) -> bool:
    """Whether the spread of a chaotic task, widened by this factor at most, would hold the converged value."""
    more = widened(spread.condition, factor) / widened(spread.condition, WIDENED_AT_MOST)
    return bool(spread.low / more <= true <= spread.high * more)


def tell(data: np.ndarray, target: float) -> dict[str, str]:
    """Print the lines of one target; the same for the documentation."""
    certified, plain = choose(accuracy=target), choose(accuracy=target, certify=False)
    if certified.accuracy < FINEST_SPLITTING:
        raise SystemExit(f"--targets: {target:g} is below those of the splitting, which is what is taken apart here")
    columns = [data[name] for name in PARAMETERS]
    tasks = [ScaledTask(int(N), z, M * M0, V * V0, LATTICE, ()) for N, z, M, V in zip(*columns, strict=True)]
    seen = [see(task, certified, plain) for task in tasks]
    bare, once, again, more, disturbed, rest = np.mean([x.seconds for x in seen], axis=0)
    off = np.array([abs(x.first.ratio / true - 1.0) for x, true in zip(seen, data["ke_ratio"], strict=True)])
    left = np.array([abs(x.verdict.best.ratio / true - 1.0) for x, true in zip(seen, data["ke_ratio"], strict=True)])
    flagged, well = np.array([x.verdict.chaotic for x in seen]), data["condition"] < promises.WELL_CONDITIONED
    chaotic, doubtful = data["shown"] > CHAOTIC, np.array([x.measured for x in seen])
    beyond = well & (off > target)
    caught, late = (beyond & (np.array([getattr(x, name) for x in seen]) > target) for name in ("error", "third"))
    third = np.array([x.asked for x in seen]).mean()
    together = once + again + more + disturbed + rest
    spreads = [(x.verdict, true) for x, true in zip(seen, data["ke_ratio"], strict=True) if x.verdict.chaotic]
    held = ", ".join(f"{sum(holds(*one, factor) for one in spreads)} ({factor:g})" for factor in FACTORS)
    print(f"target {target:g}: {together / bare:.1f} plain runs of {1e3 * bare:.2f} ms")
    print(
        f"  first run   {once / bare:5.2f}: {beyond.sum()} of {well.sum()} beyond the target, {chaotic.sum()} chaotic"
    )
    print(f"  companion   {again / bare:5.2f}: its difference tells {caught.sum()} of {beyond.sum()}")
    print(f"  third run   {more / bare:5.2f}: for {third:.1%} of the tasks; then told {late.sum()}")
    print(
        f"  disturbed   {disturbed / bare:5.2f}: for {doubtful.mean():.1%} of the tasks; "
        f"{(flagged & chaotic).sum()} of {chaotic.sum()} chaotic ones flagged, of others {(flagged & ~chaotic).sum()}"
    )
    print(f"  the rest    {rest / bare:5.2f}: {(well & ~flagged & (left > target)).sum()} left beyond the target")
    print(f"  of {len(spreads)} spreads so many would hold the converged value, widened by (..): {held}", flush=True)
    return {
        "target": f"{target:.0e}".replace("e-0", "e-"),
        "first run, tighter where the target is 1e-1 or 1e-2": f"{once / bare:.1f}",
        "companion": f"{again / bare:.1f}",
        "third run": f"{more / bare:.1f}",
        "disturbed runs": f"{disturbed / bare:.1f}",
        "spreads, refinements": f"{rest / bare:.1f}",
        "together": f"{together / bare:.1f}",
        "chaotic ones flagged": f"{(flagged & chaotic).sum()} of {chaotic.sum()}",
        "misses of the first run: told by looser runs, of all": f"{late.sum()} of {beyond.sum()}",
        "misses left": f"{(well & ~flagged & (left > target)).sum()}",
    }


def main() -> None:
    """Draw and tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=600, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--longest", type=int, default=150, metavar="N")
    parser.add_argument("--targets", type=float, nargs="+", default=[1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
    parser.add_argument("--keep", action="store_true", help="for the documentation (tests.measured)")
    args = parser.parse_args()
    data = promises.random_tasks(args.random, args.seed, args.longest, 0)
    print(f"{len(data)} tasks of seed {args.seed}; costs in plain runs of the same target")
    see(ScaledTask(5, 0.0, M0, V0, LATTICE, ()), choose(), choose(certify=False))  # compiles
    rows = [tell(data, target) for target in args.targets]
    if args.keep:
        keep("parts", rows, f"{len(data)} tasks of seed {args.seed}, up to N = {args.longest}")


if __name__ == "__main__":
    main()
