"""How far to trust one ke_ratio: its error, its condition number, and more work where it is poor.

The condition number is the relative change of ke_ratio over that of what it depends on: the impact's mass and speed,
and the first velocities of the sites, all disturbed at once. A task is chaotic where it exceeds CHAOTIC. Not only the
peak counts: a later crest that a disturbance may lift above it moves the answer as well (kernel.crests).

A looser companion run tells the error. Its steps amount to a disturbance of known size (`equivalent_disturbance`), so
that it tells the condition number, too, to a factor of some four; where that is not small, a run from a disturbed
start measures it. A task whose error exceeds its target is computed again, tighter, until it reaches it. A chaotic task
is not: digits are worth nothing there. Its spread is what an ensemble of disturbed runs spans, widened so that it holds
a converged value nine times in ten.
"""

from typing import NamedTuple

import numpy as np

from kernel.crests import PARTS
from kernel.jit import jit, written_out
from kernel.method import (
    AUTO,
    COARSEST,
    COMPANION_ACCURACY,
    COMPANION_RTOL,
    FINEST_SPLITTING,
    RK45,
    RTOL_MIN,
    Integrator,
)
from kernel.model import Array
from kernel.peaks import Peak, peak_of
from kernel.status import DONE, NOT_CONVERGED, NOT_FINITE

DISTURBANCE = 1e-6  # relative, of what the condition number is measured by
CHAOTIC = 1e3  # condition number from which a task is chaotic: its neighbours at 1e-6 differ by more than 1e-3
SENSITIVE = 100.0  # condition number that is measured twice
DOUBTFUL = 50.0  # condition number told by a companion from which it is measured
# How many times its change between two runs a crest may still grow in a third one: two runs of a chaotic crest show
# only two of its many values. Measured at 1e-3 on 700 random tasks: with 3, 4 the flag found 95, 98 % of the chaotic
# ones, and 1.2, 1.6 % of the calm ones.
MARGIN = 3.0
# What a companion differs by is mostly its own error; of the tighter run's it is at least three or four times as much.
COMPANION_SHARE, COMPANION_SHARE_RK45 = 1.0 / 3.0, 1.0 / 4.0
# Of Dormand-Prince and the splitting at PROBE_ACCURACY, from which the former cannot be right.
DISAGREEING = 1e-3
# An error from which a task is refined, however loose its target: a hundredth may be the first sign of chaos.
SUSPICIOUS = 1e-3
LEAST_ACCURACY, LEAST_RTOL = 1.5, 3.0  # the least error that is believed, in accuracies or relative tolerances
REFINEMENTS = 3
FAR = 5.0  # targets; a task whose refined runs differ by more is not converged
TIGHTER_ACCURACY, TIGHTER_RTOL = 10.0, 30.0
PROBE_ACCURACY = 3e-5  # of the splitting that asks for chaos where Dormand-Prince was wanted
# Of N zeta_T: above, the dampers bound Dormand-Prince's steps, and the implicit splitting is cheaper at any refinement.
STIFF = 10.0
OTHERS = (3.0, 4.0, 5.0)  # disturbances of a chaotic task's ensemble, in DISTURBANCE
# Measured on 150 chaotic tasks: the ensemble alone holds a converged value in 69 to 76 % of them, widened by a quarter
# in 85 to 91 %, so in 92 to 96 % (column "held" of tests.promises).
WIDER = 0.5  # either way, of its logarithmic width


class Impact(NamedTuple):
    """A task in the kernel's units: M = m_im/m_T, V in long-wave sound speeds."""

    N: int
    zeta_T: float
    M: float
    V: float


class Pair(NamedTuple):
    """Both chains of a task."""

    status: int
    ratio: float  # ke_bistable / ke_linear
    bistable: Peak
    linear: Peak


class Verdict(NamedTuple):
    """The best pair, and what is known about its ratio."""

    status: int
    best: Pair
    error: float  # estimated, relative
    condition: float  # estimated
    chaotic: bool
    low: float  # of a chaotic task: its neighbours' ratios lie between
    high: float


@jit
def pair_of(task: Impact, disturbance: float, integrator: Integrator, work: np.ndarray) -> Pair:
    """Run both chains, mass, speed and first velocities disturbed relatively; work (3,): steps, (site) evaluations."""
    M, V = task.M * (1.0 + disturbance), task.V * (1.0 + disturbance)
    bistable = peak_of(task.N, task.zeta_T, M, V, True, disturbance, integrator)
    linear = peak_of(task.N, task.zeta_T, M, V, False, disturbance, integrator)
    for run in (bistable, linear):
        work[0] += run.steps
        work[1] += run.evaluations
        work[2] += run.site_evaluations
    status, ratio = max(bistable.status, linear.status), np.nan
    if status == DONE:
        ratio = bistable.KE / linear.KE if linear.KE > 0.0 else np.nan
        status = DONE if ratio > 0.0 else NOT_FINITE
    return Pair(status, ratio, bistable, linear)


@jit
def _nearest(x: Array, y: Array, p: int) -> float:
    """Least difference of x[p] and y[p - 1 : p + 2]: a crest may pass into the next part of the run."""
    least = abs(x[p] - y[p])
    if p > 0:
        least = min(least, abs(x[p] - y[p - 1]))
    if p < PARTS - 1:
        least = min(least, abs(x[p] - y[p + 1]))
    return least


@jit
def moved(here: Array, there: Array, margin: float) -> float:
    """Relative change of the largest KE of `here` (PARTS,) if each crest changes as much as from here to `there`.

    Another crest than the largest may change `margin` times as much. Never less than the largest has changed.
    """
    top, other = 0, 0.0
    for p in range(PARTS):
        if here[p] > here[top]:
            top = p
        other = max(other, there[p])
    most = abs(here[top] - other)
    for p in range(PARTS):
        change = min(_nearest(here, there, p), _nearest(there, here, p))
        if p == top:
            most = max(most, change)
        elif (p == 0 or here[p] >= here[p - 1]) and (p == PARTS - 1 or here[p] >= here[p + 1]):  # a crest of its own
            most = max(most, here[p] + margin * change - here[top])
    return most / here[top]


@jit
def apart(a: Pair, b: Pair, margin: float) -> float:
    """Relative change of a's ratio if both chains' crests change as they do from a to b; infinite where one failed."""
    if a.status != DONE or b.status != DONE:
        return np.inf
    return moved(a.bistable.crests, b.bistable.crests, margin) + moved(a.linear.crests, b.linear.crests, margin)


@jit
def equivalent_disturbance(accuracy: float) -> float:
    """The relative disturbance of the start that moves ke_ratio as much as the steps of this accuracy do.

    The median of random tasks with condition numbers of 20 to 1000, half of it for the coarsest steps, which find less
    of the chaos that there is; from task to task it varies by a factor of four (python -m tests.convergence fits it).
    """
    return min(1.5e-4, 2.8e-5 * (accuracy / 1e-3) ** 1.4)


@jit
def certify(task: Impact, first: Pair, integrator: Integrator, work: np.ndarray) -> Verdict:
    """Judge the pair that `integrator` gave, and improve it where it needs to be."""
    loose = looser(integrator)
    companion, near = pair_of(task, 0.0, loose, work), np.nan
    error = share(integrator) * apart(first, companion, 1.0)
    if integrator.kind == AUTO:
        condition = max(1.0, apart(first, companion, MARGIN) / equivalent_disturbance(loose.accuracy))
        if condition > DOUBTFUL:
            condition, near = measured(task, first, integrator, work)
    else:
        probe = prober(integrator)
        here = pair_of(task, 0.0, probe, work)
        condition, near = measured(task, here, probe, work)
        if DISAGREEING < apart(first, here, 1.0) < np.inf:
            error = max(error, apart(first, here, 1.0))
    if CHAOTIC < condition < np.inf:
        return _flagged(task, first, companion.ratio, near, condition, integrator, work)
    error = max(error, least_error(integrator))
    if error <= wanted(integrator) and error < np.inf:
        return Verdict(DONE, first, error, known(condition), False, np.nan, np.nan)
    if integrator.target == np.inf:  # tolerances of the caller's own, and a companion that failed
        return Verdict(NOT_CONVERGED, first, np.nan, known(condition), False, np.nan, np.nan)
    return _refined(task, first, error, condition, integrator, work)


@jit
def measured(task: Impact, here: Pair, integrator: Integrator, work: np.ndarray) -> tuple[float, float]:
    """The condition number, by a run of the same method from a disturbed start, and the ratio of that.

    Where the first run says that the task is sensitive and not chaotic, a second one is asked.
    """
    there = pair_of(task, DISTURBANCE, integrator, work)
    condition = max(1.0, apart(here, there, MARGIN) / DISTURBANCE)
    if SENSITIVE < condition < CHAOTIC:
        other = 2.0 * DISTURBANCE
        condition = max(condition, apart(here, pair_of(task, other, integrator, work), MARGIN) / other)
    return condition, there.ratio


@written_out
def _flagged(
    task: Impact, best: Pair, other: float, near: float, condition: float, integrator: Integrator, work: np.ndarray
) -> Verdict:
    """A chaotic task's verdict: the ensemble is what is known and more disturbed runs, as coarse as they may be."""
    coarse, low, high = coarsest(integrator), best.ratio, best.ratio
    for ratio in (other, near):
        if ratio > 0.0:
            low, high = min(low, ratio), max(high, ratio)
    for k in OTHERS:
        there = pair_of(task, k * DISTURBANCE, coarse, work)
        if there.status == DONE:
            low, high = min(low, there.ratio), max(high, there.ratio)
    wider = (high / low) ** WIDER
    low, high = low / wider, high * wider
    return Verdict(DONE, best, max(high / best.ratio - 1.0, 1.0 - low / best.ratio), condition, True, low, high)


@written_out
def _refined(
    task: Impact, first: Pair, error: float, condition: float, integrator: Integrator, work: np.ndarray
) -> Verdict:
    """Tighten until two runs in a row agree to the target; where they do not, ask again whether the task is chaotic.

    "not_converged" where the step budget ends it, or where the last run may still be off by FAR targets. The last
    refinement is for what else would end so.
    """
    best, status = first, DONE
    for i in range(REFINEMENTS):
        if i == REFINEMENTS - 1 and error <= FAR * integrator.target:
            break
        finer = tighter(task, integrator)
        better = pair_of(task, 0.0, finer, work)
        if better.status != DONE:
            status = NOT_CONVERGED
            break
        difference = apart(better, best, 1.0)
        doubt = DOUBTFUL * equivalent_disturbance(integrator.accuracy)
        doubtful = integrator.kind == AUTO and apart(better, best, MARGIN) > doubt
        other, best = best, better
        if doubtful:
            condition, near = measured(task, best, finer, work)
            if CHAOTIC < condition < np.inf:
                return _flagged(task, best, other.ratio, near, condition, integrator, work)
        integrator = finer
        error = max(share(integrator) * difference, least_error(integrator))
        if error <= wanted(integrator):
            break
    if error > FAR * integrator.target:
        status = NOT_CONVERGED
    return Verdict(status, best, known(error), known(condition), False, np.nan, np.nan)


@jit
def known(x: float) -> float:
    """An estimate for which a run failed is none."""
    return x if x < np.inf else np.nan


@jit
def looser(x: Integrator) -> Integrator:
    """The companion's method."""
    rtol = min(0.1, x.rtol * COMPANION_RTOL)
    accuracy = min(COARSEST, x.accuracy * COMPANION_ACCURACY)
    return Integrator(x.kind, x.target, accuracy, rtol, x.atol * COMPANION_RTOL, x.max_steps)


@jit
def coarsest(x: Integrator) -> Integrator:
    """The cheapest method."""
    return Integrator(AUTO, x.target, COARSEST, x.rtol, x.atol, x.max_steps)


@jit
def prober(x: Integrator) -> Integrator:
    """The method that asks for chaos where Dormand-Prince was wanted."""
    return Integrator(AUTO, x.target, PROBE_ACCURACY, x.rtol, x.atol, x.max_steps)


@jit
def tighter(task: Impact, x: Integrator) -> Integrator:
    """The next refinement; where the splitting ends, Dormand-Prince goes on, but not against stiff dampers."""
    if x.kind == AUTO:
        accuracy = x.accuracy / TIGHTER_ACCURACY
        kind = AUTO if accuracy >= FINEST_SPLITTING or task.N * task.zeta_T >= STIFF else RK45
        rtol = max(RTOL_MIN, 1e-3 * accuracy)
        return Integrator(kind, x.target, accuracy, rtol, 1e-3 * rtol, x.max_steps)
    rtol = max(RTOL_MIN, x.rtol / TIGHTER_RTOL)
    return Integrator(x.kind, x.target, x.accuracy, rtol, x.atol * rtol / x.rtol, x.max_steps)


@jit
def wanted(x: Integrator) -> float:
    """The error at which a run needs no refinement; none is asked for at tolerances of the caller's own."""
    return x.target if x.target == np.inf else min(x.target, SUSPICIOUS)


@jit
def share(x: Integrator) -> float:
    """The part of a companion's difference that is believed to be the error of the run itself."""
    return COMPANION_SHARE if x.kind == AUTO else COMPANION_SHARE_RK45


@jit
def least_error(x: Integrator) -> float:
    """Two runs can agree by chance; the estimate is never below this."""
    return LEAST_ACCURACY * x.accuracy if x.kind == AUTO else LEAST_RTOL * x.rtol
