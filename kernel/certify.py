"""How far to trust one ke_ratio: its error, its condition number, and more work where it is poor.

A task climbs a ladder of runs, each tighter than the one before. What the two differ by tells the error
(kernel.estimate), until it is what is wanted. On every rung the two tell the condition number, too, or runs from a
disturbed start do (kernel.condition). A task is chaotic where it exceeds CHAOTIC, and climbs no further: digits are
worth nothing there. One that the looser runs of the bistable chain show to be chaotic does not even begin. Its spread
is what its runs span, disturbed ones among them, widened so that it holds a converged value nine times in ten.
"""

from typing import NamedTuple

import numpy as np

from kernel.condition import (
    CHAOTIC,
    DISTURBANCE,
    MEASURED_AGAIN_FROM,
    MEASURED_AGAIN_TO,
    Early,
    Measured,
    condition_of,
    measured,
    seen_early,
)
from kernel.estimate import (
    BETWEEN,
    COARSE,
    RTOL_STEP,
    error_by_third,
    error_felt,
    error_of,
    least_error,
    may_agree_by_chance,
)
from kernel.extrapolate import extrapolated, is_regular, suited
from kernel.jit import outer
from kernel.method import (
    ATOL_OVER_RTOL,
    AUTO,
    COARSEST,
    PROBE_ACCURACY,
    RTOL_OVER_ACCURACY,
    RTOL_SHARE,
    Integrator,
)
from kernel.model import lattice_chain
from kernel.pairs import (
    Pair,
    Rung,
    ScaledTask,
    apart,
    auto_at,
    beside,
    companion_of,
    completed,
    linear_peak,
    pair_of,
    paired,
    tighter_by,
)
from kernel.status import DONE, NOT_CONVERGED, STEP_BUDGET
from kernel.task import RTOL_MIN

# Of quantities beside ke_ratio (kernel.quantities) many are told by the late, chaotic part of a run, where run and
# companion are equally far off: what they differ by counts so many times. Of 1500 random tasks it covers 98.2 to 100 %
# of each quantity's errors, half of it 95.7 to 100 % (python -m tests.quantities --random 1500 --seed 2026).
QUANTITY_SHARE = 4.0
# A chain that is not uniform is probed by Dormand-Prince, whose steps follow the state: a disturbed run has others.
# Where they do more to a task than the disturbance, the condition number told is theirs. One that is not small is
# measured once more, at an rtol of a thousandth of the disturbance, and that counts: python -m tests.promises --chains
# listed tells how many calm tasks are flagged all the same.
PROBE_OF_VARIED = 1e-3 * DISTURBANCE / RTOL_SHARE
DISAGREEMENT = 1e-3  # of Dormand-Prince and the splitting at PROBE_ACCURACY, relative: one of them must be wrong
REFINEMENTS = 4  # at most: from the coarsest certified run to where the splitting ends
# Condition number, measured, below which two runs at coarse steps do not agree by chance, as nothing has grown on the
# way to the crest: the tighter run is spared, and what the two tell of the error counts so many times. Of 5386 and 1785
# random tasks that are not chaotic two and one are beyond 1e-2, as without this, and `error` covers 98.6 and 98.3 %, as
# without (98.6, 98.4 %). With a condition number of 10 five are beyond it, with a margin of 1 `error` covers 98.4 and
# 97.8 % (python -m tests.promises --random 6000 --seed 63001 --longest 150; --random 2000 --seed 281127).
REGULAR, MARGIN_OF_SPARED = 5.0, 2.0
TARGETS_MISSED = 5.0  # a task whose estimated error is more than so many targets in the end has not converged
# A chaotic task's last run is disturbed by so much, relatively. What all its runs span is widened, either way, by what
# that would do to a ratio of its condition number, but by no more than this factor: chaos moves a ratio so far and
# seldom further. Of 413 random ones it then holds a converged value of 95 to 97 % at targets of 1e-1 to 1e-5, of the 53
# chaotic references of 90 to 96 % (column "held" of tests.promises; what others would hold prints tests.parts).
DISTURBED_BY, WIDENED_AT_MOST = 1e-4, 1.8


class Verdict(NamedTuple):
    """The best pair, and what is known about its ratio."""

    status: int
    best: Pair
    error: float  # estimated, relative
    condition: float  # estimated
    chaotic: bool
    low: float  # of a chaotic task: its neighbours' ratios lie between
    high: float
    against: Pair  # the runs that `best` was compared with for the error
    least: float  # the smallest error that is believed; nan where none is estimated
    share: float  # of what a quantity differs by from the looser run, that counts as its error


@outer
def certify(task: ScaledTask, integrator: Integrator, work: np.ndarray) -> Verdict:
    """Run a task by `integrator`, judge what it gives, and improve it where it needs to be.

    The looser run of the bistable chain comes first: where it shows chaos beyond doubt no tighter one is worth its
    time. A refinement that fails, as by the step budget, leaves what the runs before it told.
    """
    loose, condition = companion_of(integrator), np.nan
    early = seen_early(task, loose, work)
    if MEASURED_AGAIN_TO <= early.condition < np.inf:
        return _flagged_early(task, early, loose, work)
    if early.run.run.status == STEP_BUDGET:  # tighter ones take more
        return unjudged(paired(early.run, linear_peak(task, 0.0, 0.0, integrator, work, True)))
    first = pair_of(task, integrator, work, True)
    if first.status != DONE:
        return unjudged(first)
    rung = Rung(first, integrator, completed(task, first, early.run, 0.0, loose, work, True), loose)
    seen, error = _probed(task, first, integrator, work)
    for refinements in range(REFINEMENTS + 1):
        x, doubtful = rung.integrator, may_agree_by_chance(task, rung) and refinements == 0
        error = max(error, error_of(task, rung))
        if rung.loose.kind == AUTO:
            seen = condition_of(task, rung, doubtful, early, work)
        if CHAOTIC < seen.condition < np.inf:
            return _flagged(task, rung.best, rung.against, seen, x, work)
        condition = seen.condition if seen.condition < np.inf else condition
        error = max(error, error_felt(rung, seen.condition))
        coarse = x.accuracy > COARSE
        alone = doubtful and coarse and not seen.condition < REGULAR  # two runs that may agree by chance, and no third
        if doubtful and not coarse and error <= x.target:
            error = max(error, error_by_third(task, rung, work))
        elif doubtful and coarse and not alone:
            error *= MARGIN_OF_SPARED
        if (error <= x.target and not alone) or x.target == np.inf or refinements == REFINEMENTS:
            break
        finer = tighter(task, x)
        if finer.kind == x.kind and finer.kind != AUTO and finer.rtol >= x.rtol:  # as tight as it gets
            break
        better = pair_of(task, finer, work, True)
        if better.status != DONE:
            break
        rung = Rung(better, finer, rung.best, x)
        error = still_counts(error, rung)
    status = DONE if error < np.inf and error <= TARGETS_MISSED * integrator.target else NOT_CONVERGED
    return calm(status, task, rung, error, condition)


@outer
def _flagged_early(task: ScaledTask, early: Early, loose: Integrator, work: np.ndarray) -> Verdict:
    """The verdict on a task of which no run is made that is tighter than `loose`."""
    best = paired(early.run, linear_peak(task, 0.0, 0.0, loose, work, True))
    if best.status != DONE:
        return unjudged(best)
    near = paired(early.disturbed, best.linear).ratio
    return _flagged(task, best, best, Measured(early.condition, near, np.nan), loose, work)


@outer
def still_counts(error: float, rung: Rung) -> float:
    """Which part of the error told by looser runs counts beside what the runs of this rung tell.

    It falls as the accuracy does, as two runs can agree by chance. But where a rung differed by far more than the
    target a far tighter one that does not, or two of the nearer ones, settle it.
    """
    return min(error, BETWEEN * rung.integrator.target) / tighter_by(rung) if error < np.inf else 0.0


@outer
def _probed(task: ScaledTask, first: Pair, integrator: Integrator, work: np.ndarray) -> tuple[Measured, float]:
    """What a probe sees of a task that Dormand-Prince is asked for, and by how much they disagree.

    The probe is what "auto" takes: the splitting, which knows uniform chains only, else Dormand-Prince.
    """
    if integrator.kind == AUTO:
        return Measured(np.nan, np.nan, np.nan), 0.0
    probe = auto_at(PROBE_ACCURACY, integrator)
    here = pair_of(task, probe, work, False)
    disagreement = apart(first, here, 1.0)
    seen = _seen_by(task, probe, here, work)
    if task.lattice.varied is not None and MEASURED_AGAIN_FROM < seen.condition < np.inf:
        finer = auto_at(PROBE_OF_VARIED, integrator)
        again = _seen_by(task, finer, pair_of(task, finer, work, False), work)
        if again.condition < np.inf:
            seen = Measured(again.condition, seen.near, again.near)
    return seen, disagreement if DISAGREEMENT < disagreement < np.inf else 0.0


@outer
def _seen_by(task: ScaledTask, probe: Integrator, here: Pair, work: np.ndarray) -> Measured:
    """The condition number by the steps of `probe`, whose run is `here`."""
    early = Early(probe.accuracy, here.bistable, here.bistable, np.nan)
    return measured(task, Rung(here, probe, here, probe), early, work)


@outer
def _flagged(
    task: ScaledTask, best: Pair, other: Pair, seen: Measured, integrator: Integrator, work: np.ndarray
) -> Verdict:
    """A chaotic task's verdict: its spread is told by the runs so far, and one more as coarse as may be."""
    coarse, low, high = auto_at(COARSEST, integrator), best.ratio, best.ratio
    there = beside(task, best, DISTURBED_BY, coarse, work, False)
    for ratio in (other.ratio, seen.near, seen.farther, there.ratio):
        if ratio > 0.0:  # nan where there was no run, or it failed
            low, high = min(low, ratio), max(high, ratio)
    wider = widened(seen.condition, WIDENED_AT_MOST)
    low, high = low / wider, high * wider
    error = max(high / best.ratio - 1.0, 1.0 - low / best.ratio)
    return Verdict(DONE, best, error, seen.condition, True, low, high, other, np.nan, np.nan)


@outer
def widened(condition: float, at_most: float) -> float:
    """By which factor the spread of a chaotic task is wider, either way, than what its runs span."""
    return min(at_most, 1.0 + DISTURBED_BY * condition)


@outer
def unjudged(first: Pair) -> Verdict:
    """What is known of a pair that nobody certifies."""
    return Verdict(first.status, first, np.nan, np.nan, False, np.nan, np.nan, first, np.nan, np.nan)


@outer
def calm(status: int, task: ScaledTask, rung: Rung, error: float, condition: float) -> Verdict:
    """The verdict on a task that is not chaotic, from the last two runs that it climbed to."""
    share = QUANTITY_SHARE / (tighter_by(rung) - 1.0) if is_regular(task, rung) else QUANTITY_SHARE
    error, condition, least = known(error), known(condition), least_error(task, rung)
    best, against = extrapolated(task, rung), rung.against
    return Verdict(status, best, error, condition, False, np.nan, np.nan, against, least, share)


@outer
def error_of_quantity(verdict: Verdict, k: int) -> float:
    """Estimated relative error of quantity k: of either chain's value, and of their ratio.

    nan where the pair is not certified or chaotic, where nothing is left to compare it with, or a ratio is none.
    """
    best, against = verdict.best, verdict.against
    if against.status != DONE or not verdict.least < np.inf:
        return np.nan
    if best.linear.largest[k] == 0.0 or against.linear.largest[k] == 0.0:  # an impulse may be negative
        return np.nan
    change = abs(against.bistable.largest[k] / best.bistable.largest[k] - 1.0)
    change += abs(against.linear.largest[k] / best.linear.largest[k] - 1.0)
    return max(verdict.least, verdict.share * change) if change < np.inf else np.nan


@outer
def known(x: float) -> float:
    """An estimate for which a run failed is none."""
    return x if x < np.inf else np.nan


@outer
def tighter(task: ScaledTask, x: Integrator) -> Integrator:
    """The next refinement; where the explicit splitting ends, Dormand-Prince goes on."""
    if x.kind == AUTO:
        accuracy = x.accuracy * (x.accuracy / companion_of(x).accuracy)  # as much tighter as its companion is looser
        rtol = max(RTOL_MIN, RTOL_OVER_ACCURACY * accuracy)
        finer = Integrator(AUTO, x.target, accuracy, rtol, ATOL_OVER_RTOL * rtol, x.max_steps)
        chain = lattice_chain(task.N, task.zeta_T, task.M, task.lattice)
        return suited(chain.zeta, finer)
    rtol = max(RTOL_MIN, x.rtol / RTOL_STEP)
    return Integrator(x.kind, x.target, x.accuracy, rtol, x.atol * rtol / x.rtol, x.max_steps)
