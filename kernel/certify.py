"""How far to trust one ke_ratio: its error, whether the inputs determine it at all, and more work where it is poor.

A task is chaotic where neighbours at relative distance 1e-6 in V differ by more than 1e-3 in ke_ratio, or where two
runs still differ by more than that, and by more than five targets, after every refinement; its spread is the interval
over those neighbours, or those runs.

A looser companion run tells the error. Only a task whose two runs disagree costs more: a neighbour at relative distance
1e-6 in V tells whether it is chaotic; if not, it is computed again, ten times tighter, until it reaches its target.
"""

from typing import NamedTuple

import numpy as np

from kernel.jit import jit
from kernel.method import AUTO, COMPANION_ACCURACY, COMPANION_RTOL, FINEST_SPLITTING, RK45, RTOL_MIN, Integrator
from kernel.peaks import Peak, peak_of
from kernel.status import DONE, NOT_CONVERGED, NOT_FINITE

SUSPICIOUS = 3e-3  # disagreement from which a neighbour is asked, however loose the target
NEIGHBOUR = 1e-6  # relative distance in V
CHAOTIC = 1e-3  # relative difference of neighbours from which a task is chaotic
NEAREST, FURTHER = (1.0, -1.0), (2.0, -2.0, 3.0, -3.0)  # neighbours asked first, and of a chaotic task, in NEIGHBOUR
# Neighbours are compared at least this tightly: the error of a loose run hides how near they are.
PROBE_ACCURACY, PROBE_RTOL = 3e-4, 1e-6
REFINEMENTS = 2
FAR = 5.0  # targets; a refined task whose last two runs differ by more is flagged
TIGHTER_ACCURACY, TIGHTER_RTOL = 10.0, 30.0


class Impact(NamedTuple):
    """A task in the kernel's units: M = m_im/m_T, V in long-wave sound speeds."""

    N: int
    zeta_T: float
    M: float
    V: float


class Pair(NamedTuple):
    """Both chains of a task."""

    status: int
    ratio: float  # ke_bistable / ke_linear; TE cancels
    bistable: Peak
    linear: Peak


class Verdict(NamedTuple):
    """The best pair, and what is known about its ratio."""

    status: int
    best: Pair
    error: float  # estimated relative error of the ratio
    chaotic: bool
    low: float  # of the ratio over the neighbours of a chaotic task; nan of another
    high: float


@jit
def pair_of(task: Impact, integrator: Integrator, work: np.ndarray) -> Pair:
    """Integrate both chains; adds steps, evaluations and site evaluations to `work` (3,)."""
    bistable = peak_of(task.N, task.zeta_T, task.M, task.V, True, integrator)
    linear = peak_of(task.N, task.zeta_T, task.M, task.V, False, integrator)
    for run in (bistable, linear):
        work[0] += run.steps
        work[1] += run.evaluations
        work[2] += run.site_evaluations
    status, ratio = max(bistable.status, linear.status), np.nan
    if status == DONE:
        below = linear.speed**2
        ratio = bistable.speed**2 / below if below > 0.0 else np.nan
        status = DONE if ratio > 0.0 else NOT_FINITE
    return Pair(status, ratio, bistable, linear)


@jit
def certify(task: Impact, first: Pair, integrator: Integrator, work: np.ndarray) -> Verdict:
    """Judge the pair that `integrator` gave, and improve it where it needs to be."""
    companion = pair_of(task, looser(integrator), work)
    error = disagreement(companion, first)
    if not error > min(integrator.target, SUSPICIOUS):
        return Verdict(DONE, first, max(error, least_error(integrator)), False, np.nan, np.nan)
    probe = Integrator(
        integrator.kind,
        integrator.target,
        min(integrator.accuracy, PROBE_ACCURACY),
        min(integrator.rtol, PROBE_RTOL),
        min(integrator.atol, PROBE_RTOL * integrator.atol / integrator.rtol),
        integrator.max_steps,
    )
    loose = integrator.accuracy > PROBE_ACCURACY if integrator.kind == AUTO else integrator.rtol > PROBE_RTOL
    here = pair_of(task, probe, work) if loose else first
    low, high, moved, asked = min(first.ratio, here.ratio), max(first.ratio, here.ratio), 0.0, 0
    for k in NEAREST:
        there = pair_of(neighbour(task, k), probe, work)
        if here.status == DONE and there.status == DONE:
            moved, asked = max(moved, disagreement(here, there)), asked + 1
            low, high = spread(there, low, high)
    if asked == 0:
        return Verdict(NOT_CONVERGED, first, error, False, np.nan, np.nan)
    if moved > CHAOTIC:
        for k in FURTHER:
            low, high = spread(pair_of(neighbour(task, k), probe, work), low, high)
        return Verdict(DONE, first, max(error, high / first.ratio - 1.0, 1.0 - low / first.ratio), True, low, high)
    return refine(task, first, error, integrator, work)


@jit
def spread(there: Pair, low: float, high: float) -> tuple[float, float]:
    """The interval from low to high, widened to hold a neighbour's ratio."""
    return (min(low, there.ratio), max(high, there.ratio)) if there.status == DONE else (low, high)


@jit
def refine(task: Impact, best: Pair, error: float, integrator: Integrator, work: np.ndarray) -> Verdict:
    """Tighten until two runs in a row agree to the target.

    Runs that still disagree by far are as undetermined as neighbours that do: the task is flagged like a chaotic one.
    "not_converged" where the step budget ends it, or where the error stays above FAR targets.
    """
    low, high, status = best.ratio, best.ratio, DONE
    for _ in range(REFINEMENTS):
        if not error > integrator.target:
            break
        integrator = tighter(integrator)
        better = pair_of(task, integrator, work)
        if better.status != DONE:
            status = NOT_CONVERGED
            break
        error = disagreement(best, better)
        best = better
        low, high = spread(best, low, high)
    error = max(error, least_error(integrator))
    if status == DONE and error > max(CHAOTIC, FAR * integrator.target):
        return Verdict(DONE, best, error, True, low, high)
    status = NOT_CONVERGED if error > FAR * integrator.target else status
    return Verdict(status, best, error, False, np.nan, np.nan)


@jit
def disagreement(a: Pair, b: Pair) -> float:
    """Relative difference; infinite where one of them failed."""
    return abs(a.ratio / b.ratio - 1.0) if a.status == DONE and b.status == DONE else np.inf


@jit
def neighbour(task: Impact, k: float) -> Impact:
    """The same impact, k NEIGHBOUR faster."""
    return Impact(task.N, task.zeta_T, task.M, task.V * (1.0 + k * NEIGHBOUR))


@jit
def looser(x: Integrator) -> Integrator:
    """The companion's method: the difference of the two tells the error, for half to two thirds of the cost."""
    rtol = min(0.1, x.rtol * COMPANION_RTOL)
    return Integrator(x.kind, x.target, x.accuracy * COMPANION_ACCURACY, rtol, x.atol * COMPANION_RTOL, x.max_steps)


@jit
def tighter(x: Integrator) -> Integrator:
    """The next refinement; where the splitting ends, Dormand-Prince goes on."""
    if x.kind == AUTO:
        accuracy = x.accuracy / TIGHTER_ACCURACY
        kind = AUTO if accuracy >= FINEST_SPLITTING else RK45
        rtol = max(RTOL_MIN, 1e-3 * accuracy)
        return Integrator(kind, x.target, accuracy, rtol, 1e-3 * rtol, x.max_steps)
    rtol = max(RTOL_MIN, x.rtol / TIGHTER_RTOL)
    return Integrator(x.kind, x.target, x.accuracy, rtol, x.atol * rtol / x.rtol, x.max_steps)


@jit
def least_error(x: Integrator) -> float:
    """Two runs can agree by chance; the estimate is never below this."""
    return x.accuracy if x.kind == AUTO else 3.0 * x.rtol
