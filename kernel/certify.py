"""How far to trust one ke_ratio: its error, its condition number, and more work where it is poor.

The condition number is the relative change of ke_ratio over that of what it depends on: the impact's mass and speed,
and the first velocities of the sites, all disturbed at once. A task is chaotic where it exceeds CHAOTIC. Not only the
peak counts: a later crest that a disturbance may lift above it moves the answer as well (kernel.watch).

A looser companion run tells the error. Its steps amount to a disturbance of known size (`equivalent_disturbance`), so
that it tells the condition number, too, to a factor of some four; where that is not small, a run from a disturbed
start measures it. A task whose error exceeds its target is computed again, tighter, until it reaches it. A chaotic task
is not: digits are worth nothing there. Its spread is what an ensemble of disturbed runs spans, widened so that it holds
a converged value nine times in ten.
"""

from typing import Any, NamedTuple

import numpy as np

from kernel.crests import moved, wins_late
from kernel.integrate import Peak, peak_of
from kernel.jit import outer
from kernel.method import (
    ATOL_OVER_RTOL,
    AUTO,
    COARSEST,
    EXPLICIT,
    FINEST_SPLITTING,
    PROBE_ACCURACY,
    RK45,
    RTOL_OVER_ACCURACY,
    Integrator,
    at_accuracy,
    looser,
)
from kernel.model import frequency_of, lattice_chain, linear_chain
from kernel.status import DONE, NOT_CONVERGED, NOT_FINITE
from kernel.task import RTOL_MIN

companion_of, auto_at = outer(looser), outer(at_accuracy)

DISTURBANCE = 1e-6  # relative, of what the condition number is measured by
CHAOTIC = 1e3  # condition number from which a task is chaotic: its neighbours at 1e-6 differ by more than 1e-3
# A companion tells the condition number to a factor of four. Where it tells more than MEASURED_FROM, a twentieth of
# CHAOTIC, the condition number is measured, and where that gives more than MEASURED_TWICE_FROM, measured once more.
MEASURED_FROM, MEASURED_TWICE_FROM = 50.0, 100.0
# How many times its change between two runs a crest may still grow in a third one: two runs of a chaotic crest show
# only two of its many values. Measured at 1e-3 on 700 random tasks: with 3, 4 the flag found 95, 98 % of the chaotic
# ones, and 1.2, 1.6 % of the calm ones (the columns "flagged" and "false" of tests.promises --random).
CREST_GROWTH = 3.0
# What a companion differs by is mostly its own error; of the tighter run's it is at least three times as much. Two runs
# can agree by chance: the error is never believed to be below ERROR_PER_ACCURACY accuracies or ERROR_PER_RTOL relative
# tolerances. python -m tests.convergence prints what other numbers would cover, and by how much.
COMPANION_SHARE, ERROR_PER_ACCURACY, ERROR_PER_RTOL = 1.0 / 3.0, 0.5, 3.0
# Where a law's stiffness jumps, the explicit splitting loses its order, and what it differs by counts twice: of 651
# random tasks of a chain of straight pieces a third of it covered 87 %, the whole of it 93 %.
SHARE_WHERE_IT_JUMPS = 2.0
# Of quantities beside ke_ratio (kernel.quantities) many are told by the late, chaotic part of a run, where run and
# companion are equally far off: what they differ by counts so many times. Of 1500 random tasks it covers 98.3 to 100 %
# of each quantity's errors, half of it 95.7 to 100 % (python -m tests.quantities --random 1500 --seed 2026).
QUANTITY_SHARE = 2.0
# Where dampers are weak, a crest that comes later than sound crosses the chain is the work of reflections and knocks:
# errors grow until run and companion are equally far off and may agree by chance. Where such a crest wins or nearly
# wins, a second companion is asked, SECOND_LOOSER times looser than the run. Of 3692 random tasks of 5 to 60 sites 16,
# 27, 30 in 100 are asked at targets 1e-3, 1e-4, 1e-5, and 4 silent misses are left of 29.
SECOND_LOOSER = 3.0
DISAGREEMENT = 1e-3  # of Dormand-Prince and the splitting at PROBE_ACCURACY, relative: one of them must be wrong
REFINED_FROM = 1e-3  # error from which a task is refined, however loose its target: it may be the first sign of chaos
# Two refinements for a task that misses its target, one more for what would end as not converged: an estimated error
# of more than TARGETS_MISSED targets.
REFINEMENTS, TARGETS_MISSED = 3, 5.0
# How much tighter each refinement is: the splitting's accuracy, and Dormand-Prince's tolerances.
ACCURACY_STEP, RTOL_STEP = 10.0, 30.0
# N zeta_T from which a refinement stays with "auto", however tight: strong dampers bound the steps of Dormand-Prince,
# not those of the linear chain's modes and of the implicit splitting.
STIFF_FROM = 10.0
ENSEMBLE = (3.0, 4.0, 5.0)  # disturbances of a chaotic task's ensemble, in DISTURBANCE
# Measured on 150 chaotic tasks: the ensemble alone holds a converged value in 69 to 76 % of them, widened by a quarter
# in 85 to 91 %, so in 92 to 96 % (column "held" of tests.promises).
WIDENING = 0.5  # either way, of its logarithmic width


class ScaledTask(NamedTuple):
    """A task in the kernel's units: M = m_im/m_T, V in long-wave sound speeds."""

    N: int
    zeta_T: float
    M: float
    V: float
    lattice: Any  # of kernel.model
    quantities: Any  # tuple of kernel.quantities that are asked for


class Pair(NamedTuple):
    """Both chains of a task."""

    status: int
    ratio: float  # ke_bistable / ke_linear
    bistable: Peak
    linear: Peak


class Measured(NamedTuple):
    """A condition number, and the ratios of the disturbed runs behind it; nan where there was none."""

    condition: float
    near: float
    farther: float


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


@outer
def pair_of(task: ScaledTask, disturbance: float, integrator: Integrator, work: np.ndarray, watched: bool) -> Pair:
    """Run both chains, mass, speed and first velocities disturbed relatively; work (3,): steps, (site) evaluations.

    watched: whether the task's quantities are looked at.
    """
    M, V, lattice, asked = task.M * (1.0 + disturbance), task.V * (1.0 + disturbance), task.lattice, task.quantities
    V /= frequency_of(lattice)
    bistable = peak_of(lattice_chain(task.N, task.zeta_T, M, lattice), V, disturbance, integrator, asked, watched)
    linear = peak_of(linear_chain(task.N, task.zeta_T, M, lattice), V, disturbance, integrator, asked, watched)
    counted(bistable, work)
    counted(linear, work)
    return paired(bistable, linear)


@outer
def counted(peak: Peak, work: np.ndarray) -> None:
    """Add what its run took to work (3,)."""
    work[0] += peak.run.steps
    work[1] += peak.run.evaluations
    work[2] += peak.run.site_evaluations


@outer
def paired(bistable: Peak, linear: Peak) -> Pair:
    """Both chains' peaks as a pair; its status is the worse of both."""
    status, ratio = max(bistable.run.status, linear.run.status), np.nan
    if status == DONE:
        ratio = bistable.KE / linear.KE if linear.KE > 0.0 else np.nan
        status = DONE if ratio > 0.0 else NOT_FINITE
    return Pair(status, ratio, bistable, linear)


@outer
def apart(a: Pair, b: Pair, margin: float) -> float:
    """Relative change of a's ratio if both chains' crests change as from a to b; infinite where one failed."""
    if a.status != DONE or b.status != DONE:
        return np.inf
    return moved(a.bistable.crests, b.bistable.crests, margin) + moved(a.linear.crests, b.linear.crests, margin)


@outer
def estimated(task: ScaledTask, here: Pair, companion: Pair, integrator: Integrator, work: np.ndarray) -> float:
    """Relative error of a run's ratio, as its companion tells it, and a second one where a late crest counts."""
    share = share_of(task.lattice.spring, here.bistable.method)
    error = share * apart(here, companion, 1.0)
    t_end = task.lattice.t_end * frequency_of(task.lattice)  # in times that sound takes to cross the chain
    late = wins_late(here.bistable.crests, t_end) or wins_late(here.linear.crests, t_end)
    if here.bistable.method == EXPLICIT and late and error <= wanted(integrator):
        second = pair_of(task, 0.0, auto_at(SECOND_LOOSER * integrator.accuracy, integrator), work, False)
        error = max(error, apart(here, second, 1.0))
    return error


@outer
def share_of(spring: Any, method: int) -> float:
    """Which part of what a run and its companion differ by is the run's error."""
    return SHARE_WHERE_IT_JUMPS if spring.stiffness_jumps() and method == EXPLICIT else COMPANION_SHARE


@outer
def equivalent_disturbance(accuracy: float) -> float:
    """The relative disturbance of the start that moves ke_ratio as much as the steps of this accuracy do.

    The median of random tasks with condition numbers of 20 to 1000; from task to task it varies by a factor of four.
    python -m tests.convergence prints it for every accuracy that a companion can have.
    """
    return 2.8e-5 * (accuracy / 1e-3) ** 1.4


@outer
def told(here: Pair, companion: Pair, accuracy: float) -> float:
    """The condition number that a run and its companion of this accuracy tell."""
    return max(1.0, apart(here, companion, CREST_GROWTH) / equivalent_disturbance(accuracy))


@outer
def certify(task: ScaledTask, first: Pair, integrator: Integrator, work: np.ndarray) -> Verdict:
    """Judge the pair that `integrator` gave, and improve it where it needs to be."""
    loose = companion_of(integrator)
    companion = pair_of(task, 0.0, loose, work, True)
    error = estimated(task, first, companion, integrator, work)
    if integrator.kind == AUTO:
        seen = Measured(told(first, companion, loose.accuracy), np.nan, np.nan)
        if seen.condition > MEASURED_FROM:
            seen = measured(task, first, integrator, work)
    else:
        probe = auto_at(PROBE_ACCURACY, integrator)
        here = pair_of(task, 0.0, probe, work, False)
        seen = measured(task, here, probe, work)
        if DISAGREEMENT < apart(first, here, 1.0) < np.inf:
            error = max(error, apart(first, here, 1.0))
    if CHAOTIC < seen.condition < np.inf:
        return _flagged(task, first, companion, seen, integrator, work)
    error = max(error, least_error(integrator))
    if error <= wanted(integrator) and error < np.inf:
        return calm(DONE, first, error, seen.condition, companion, integrator)
    if integrator.target == np.inf:  # tolerances of the caller's own, and a companion that failed
        return calm(NOT_CONVERGED, first, np.nan, seen.condition, companion, integrator)
    return _refined(task, first, companion, error, seen.condition, integrator, work)


@outer
def measured(task: ScaledTask, here: Pair, integrator: Integrator, work: np.ndarray) -> Measured:
    """The condition number, by a run from a disturbed start, and by a second one where that says: not yet chaotic."""
    there = pair_of(task, DISTURBANCE, integrator, work, False)
    condition, farther = max(1.0, apart(here, there, CREST_GROWTH) / DISTURBANCE), np.nan
    if MEASURED_TWICE_FROM < condition < CHAOTIC:
        size = 2.0 * DISTURBANCE
        other = pair_of(task, size, integrator, work, False)
        condition, farther = max(condition, apart(here, other, CREST_GROWTH) / size), other.ratio
    return Measured(condition, there.ratio, farther)


@outer
def _flagged(
    task: ScaledTask, best: Pair, other: Pair, seen: Measured, integrator: Integrator, work: np.ndarray
) -> Verdict:
    """A chaotic task's verdict: the ensemble is what is known and more disturbed runs, as coarse as they may be."""
    coarse, low, high = auto_at(COARSEST, integrator), best.ratio, best.ratio
    for ratio in (other.ratio, seen.near, seen.farther):
        if ratio > 0.0:
            low, high = min(low, ratio), max(high, ratio)
    for k in ENSEMBLE:
        there = pair_of(task, k * DISTURBANCE, coarse, work, False)
        if there.status == DONE:
            low, high = min(low, there.ratio), max(high, there.ratio)
    wider = (high / low) ** WIDENING
    low, high = low / wider, high * wider
    error = max(high / best.ratio - 1.0, 1.0 - low / best.ratio)
    return Verdict(DONE, best, error, seen.condition, True, low, high, other, np.nan)


@outer
def _refined(
    task: ScaledTask,
    first: Pair,
    companion: Pair,
    error: float,
    condition: float,
    integrator: Integrator,
    work: np.ndarray,
) -> Verdict:
    """Tighten until a run's estimated error is what is wanted, or TARGETS_MISSED targets at most after two refinements.

    Where two runs differ by more than their steps explain, it is asked again whether the task is chaotic. A refinement
    that fails, as by the step budget, leaves what the runs before it told.
    """
    best, against = first, companion
    for i in range(REFINEMENTS):
        if i == REFINEMENTS - 1 and error <= TARGETS_MISSED * integrator.target:
            break
        finer = tighter(task, integrator)
        better = pair_of(task, 0.0, finer, work, True)
        if better.status != DONE:
            break
        error = estimated(task, better, best, finer, work)
        if integrator.kind == AUTO and told(better, best, integrator.accuracy) > MEASURED_FROM:
            seen = measured(task, better, finer, work)
            if CHAOTIC < seen.condition < np.inf:
                return _flagged(task, better, best, seen, integrator, work)
            if seen.condition < np.inf:
                condition = seen.condition
        best, against, integrator = better, best, finer
        error = max(error, least_error(integrator))
        if error <= wanted(integrator):
            break
    status = DONE if error <= TARGETS_MISSED * integrator.target else NOT_CONVERGED
    return calm(status, best, error, condition, against, integrator)


@outer
def unjudged(first: Pair) -> Verdict:
    """What is known of a pair that nobody certifies."""
    return Verdict(first.status, first, np.nan, np.nan, False, np.nan, np.nan, first, np.nan)


@outer
def calm(status: int, best: Pair, error: float, condition: float, against: Pair, integrator: Integrator) -> Verdict:
    """Of a task that is not chaotic."""
    error, condition, least = known(error), known(condition), least_error(integrator)
    return Verdict(status, best, error, condition, False, np.nan, np.nan, against, least)


@outer
def error_of_quantity(verdict: Verdict, k: int) -> float:
    """Estimated relative error of quantity k: of either chain's value, and of their ratio.

    nan where the pair is not certified or chaotic, where nothing is left to compare it with, or a ratio is none.
    """
    best, against = verdict.best, verdict.against
    if against.status != DONE or not verdict.least < np.inf:
        return np.nan
    if not (best.linear.largest[k] > 0.0 and against.linear.largest[k] > 0.0):
        return np.nan
    change = abs(against.bistable.largest[k] / best.bistable.largest[k] - 1.0)
    change += abs(against.linear.largest[k] / best.linear.largest[k] - 1.0)
    return max(verdict.least, QUANTITY_SHARE * change) if change < np.inf else np.nan


@outer
def known(x: float) -> float:
    """An estimate for which a run failed is none."""
    return x if x < np.inf else np.nan


@outer
def tighter(task: ScaledTask, x: Integrator) -> Integrator:
    """The next refinement; where the splitting ends, Dormand-Prince goes on, but not against stiff dampers."""
    if x.kind == AUTO:
        accuracy = x.accuracy / ACCURACY_STEP
        kind = AUTO if accuracy >= FINEST_SPLITTING or task.N * task.zeta_T >= STIFF_FROM else RK45
        rtol = max(RTOL_MIN, RTOL_OVER_ACCURACY * accuracy)
        return Integrator(kind, x.target, accuracy, rtol, ATOL_OVER_RTOL * rtol, x.max_steps)
    rtol = max(RTOL_MIN, x.rtol / RTOL_STEP)
    return Integrator(x.kind, x.target, x.accuracy, rtol, x.atol * rtol / x.rtol, x.max_steps)


@outer
def wanted(x: Integrator) -> float:
    """The error at which a run needs no refinement; none is asked for at tolerances of the caller's own."""
    return x.target if x.target == np.inf else min(x.target, REFINED_FROM)


@outer
def least_error(x: Integrator) -> float:
    """The least error that is believed."""
    return ERROR_PER_ACCURACY * x.accuracy if x.kind == AUTO else ERROR_PER_RTOL * x.rtol
