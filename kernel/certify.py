"""How far to trust one ke_ratio: its error, whether the inputs determine it at all, and more work where it is poor.

A task is chaotic where neighbours at relative distance 1e-6 in V differ by more than 1e-3 in ke_ratio, or where two
fine runs differ by more than a tenth, or still by more than 1e-3 and than the target after every refinement.

A looser companion run tells the error and, where chaos is possible, one neighbour at the same step the sensitivity.
Only a task whose runs disagree costs more: neighbours on both sides tell whether it is chaotic; if not, it is computed
again, ten times tighter, until it reaches its target, and its neighbours are asked again. A chaotic task's spread is
what an ensemble of neighbours and of looser runs spans, widened so that it holds a converged value nine times in ten.
"""

from typing import NamedTuple

import numpy as np

from kernel.jit import jit, written_out
from kernel.method import AUTO, COMPANION_ACCURACY, COMPANION_RTOL, FINEST_SPLITTING, RK45, RTOL_MIN, Integrator
from kernel.model import M0, V0
from kernel.peaks import Peak, peak_of
from kernel.status import DONE, NOT_CONVERGED, NOT_FINITE

SUSPICIOUS = 3e-3  # disagreement of runs from which neighbours are asked, however loose the target
NEIGHBOUR = 1e-6  # relative distance in V
CHAOTIC = 1e-3  # relative difference of neighbours from which a task is chaotic
DOUBTFUL = 3e-5  # the same, from which a task is looked at more closely: a condition number of 30
TELLING_RTOL = 1e-3  # a run at looser tolerances of the caller's own says nothing about chaos
APART = 0.1  # relative difference of two runs, the looser at accuracy 1e-3 or below, from which a task is flagged
# Chaos was found for N from 14, N zeta_T up to 0.05 and impact energies from 0.13 of the nominal one (800 random tasks
# of up to 220 sites); elsewhere no neighbour is asked unless the companion disagrees.
FEWEST, MOST_DAMPED, LEAST_ENERGY = 7, 0.2, 0.03
OTHERS = (1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0)  # the ensemble of a chaotic task, in NEIGHBOUR
# Measured on 45 random chaotic tasks: the ensemble alone holds a converged value in 79 % of them, so widened in 93 %.
WIDER = 0.25  # either way, of its logarithmic width
# Neighbours are compared at least this tightly: the error of a loose run hides how near they are.
PROBE_ACCURACY, PROBE_RTOL = 3e-4, 1e-6
# The least error that is believed, measured on the references: with the accuracy itself it was above the true one in
# 97.6 to 98.8 % of them, so in 98.4 to 100 %.
LEAST_ACCURACY, LEAST_RTOL = 1.5, 3.0
REFINEMENTS = 2
FAR = 5.0  # targets; a task whose refined runs differ by more is not converged
TIGHTER_ACCURACY, TIGHTER_RTOL = 10.0, 30.0
# Of N zeta_T: above, the dampers bound Dormand-Prince's steps, and the implicit splitting is cheaper at any refinement.
STIFF = 10.0


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
    bistable = peak_of(task.N, task.zeta_T, task.M, task.V, True, 0.0, integrator)
    linear = peak_of(task.N, task.zeta_T, task.M, task.V, False, 0.0, integrator)
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


@written_out
def certify(task: Impact, first: Pair, integrator: Integrator, work: np.ndarray) -> Verdict:
    """Judge the pair that `integrator` gave, and improve it where it needs to be."""
    companion = pair_of(task, looser(integrator), work)
    error = disagreement(companion, first)
    suspicious = error > min(integrator.target, SUSPICIOUS)
    if not suspicious and can_be_chaotic(task):
        suspicious = _sensitivity(task, first, integrator, NEIGHBOUR, 0.0, work) > DOUBTFUL
    if not suspicious:
        return Verdict(DONE, first, max(error, least_error(integrator)), False, np.nan, np.nan)
    probe = prober(integrator)
    loose = integrator.accuracy > PROBE_ACCURACY if integrator.kind == AUTO else integrator.rtol > PROBE_RTOL
    here = pair_of(task, probe, work) if loose else first
    moved = _sensitivity(task, here, probe, NEIGHBOUR, NEIGHBOUR, work)
    if moved == np.inf:
        return Verdict(NOT_CONVERGED, first, error, False, np.nan, np.nan)
    apart = disagreement(first, here) if loose else error
    own_tolerances = integrator.target == np.inf
    telling = not own_tolerances or integrator.rtol <= TELLING_RTOL
    if moved > CHAOTIC or (telling and APART < apart < np.inf):
        return _flagged(task, first, here, error, probe, work)
    if own_tolerances:  # nothing to refine to
        error = max(error, apart) if apart < np.inf else error
        return Verdict(DONE, first, max(error, least_error(integrator)), False, np.nan, np.nan)
    return _refine(task, here, apart, moved > DOUBTFUL, probe, work)


@jit
def can_be_chaotic(task: Impact) -> bool:
    """Whether chaos is possible at all: enough sites, weak dampers, enough energy to flip a few springs."""
    energy = task.M * task.V**2 / (M0 * V0**2)
    return task.N >= FEWEST and task.N * task.zeta_T <= MOST_DAMPED and energy >= LEAST_ENERGY


@written_out
def _sensitivity(task: Impact, here: Pair, integrator: Integrator, up: float, down: float, work: np.ndarray) -> float:
    """The largest relative difference from the neighbours at these relative distances in V (0: none) that finish.

    Infinite if none does.
    """
    moved, asked = 0.0, 0
    for distance in (up, -down):
        if distance == 0.0:
            continue
        there = pair_of(neighbour(task, distance), integrator, work)
        if here.status == DONE and there.status == DONE:
            moved, asked = max(moved, disagreement(here, there)), asked + 1
    return moved if asked > 0 else np.inf


@written_out
def _flagged(task: Impact, best: Pair, other: Pair, error: float, probe: Integrator, work: np.ndarray) -> Verdict:
    """A chaotic task's verdict: the ensemble is its neighbours by `probe`, two looser runs, and what is known."""
    low, high = min(best.ratio, other.ratio), max(best.ratio, other.ratio)
    integrator = probe
    for _ in range(3):
        low, high = spread(pair_of(task, integrator, work), low, high)
        integrator = looser(integrator)
    for k in OTHERS:
        low, high = spread(pair_of(neighbour(task, k * NEIGHBOUR), probe, work), low, high)
    wider = (high / low) ** WIDER
    low, high = low / wider, high * wider
    return Verdict(DONE, best, max(error, high / best.ratio - 1.0, 1.0 - low / best.ratio), True, low, high)


@jit
def spread(there: Pair, low: float, high: float) -> tuple[float, float]:
    """The interval from low to high, widened to hold a neighbour's ratio."""
    return (min(low, there.ratio), max(high, there.ratio)) if there.status == DONE else (low, high)


@written_out
def _refine(task: Impact, here: Pair, apart: float, doubtful: bool, probe: Integrator, work: np.ndarray) -> Verdict:
    """Tighten, if `doubtful` at least once, until two runs in a row agree to the target; ask the neighbours again.

    Runs that still disagree are as undetermined as neighbours that do: the task is flagged like a chaotic one.
    "not_converged" where the step budget ends it, or where two runs still differ by FAR targets.
    """
    best, status, integrator, own = here, DONE, probe, np.inf
    wanted = min(probe.target, CHAOTIC)
    for i in range(REFINEMENTS):
        if apart <= wanted and not (doubtful and i == 0):
            own = _own_error(integrator, _sensitivity(task, best, integrator, least_error(integrator), 0.0, work))
            if own <= probe.target:
                break
        finer = tighter(task, integrator)
        better = pair_of(task, finer, work)
        if better.status != DONE:
            status = NOT_CONVERGED
            break
        apart = disagreement(best, better)
        best, integrator, own = better, finer, np.inf
        if CHAOTIC < _sensitivity(task, best, integrator, NEIGHBOUR, NEIGHBOUR, work) < np.inf:
            return _flagged(task, best, here, apart, probe, work)
    if status == DONE and apart > max(CHAOTIC, probe.target):
        return _flagged(task, best, here, apart, probe, work)
    if own == np.inf:
        own = _own_error(integrator, _sensitivity(task, best, integrator, least_error(integrator), 0.0, work))
    error = max(apart, own)
    return Verdict(NOT_CONVERGED if apart > FAR * probe.target else status, best, error, False, np.nan, np.nan)


@jit
def _own_error(integrator: Integrator, moved: float) -> float:
    """The method's own error, or what a change of V by its size makes of the ratio (`moved`) where that is larger."""
    own = least_error(integrator)
    return max(own, moved) if moved < np.inf else own


@jit
def disagreement(a: Pair, b: Pair) -> float:
    """Relative difference; infinite where one of them failed."""
    return abs(a.ratio / b.ratio - 1.0) if a.status == DONE and b.status == DONE else np.inf


@jit
def neighbour(task: Impact, distance: float) -> Impact:
    """The same impact, faster by a relative `distance`."""
    return Impact(task.N, task.zeta_T, task.M, task.V * (1.0 + distance))


@jit
def prober(x: Integrator) -> Integrator:
    """The method by which neighbours are compared."""
    rtol = min(x.rtol, PROBE_RTOL)
    return Integrator(x.kind, x.target, min(x.accuracy, PROBE_ACCURACY), rtol, x.atol * rtol / x.rtol, x.max_steps)


@jit
def looser(x: Integrator) -> Integrator:
    """The companion's method: the difference of the two tells the error, for half to two thirds of the cost."""
    rtol = min(0.1, x.rtol * COMPANION_RTOL)
    return Integrator(x.kind, x.target, x.accuracy * COMPANION_ACCURACY, rtol, x.atol * COMPANION_RTOL, x.max_steps)


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
def least_error(x: Integrator) -> float:
    """Two runs can agree by chance; the estimate is never below this."""
    return LEAST_ACCURACY * x.accuracy if x.kind == AUTO else LEAST_RTOL * x.rtol
