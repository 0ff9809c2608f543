"""The condition number of a task: told by a run and its companion, measured by runs from a disturbed start.

It is the relative change of ke_ratio over that of what it depends on: the impact's mass and speed, the damping and the
first velocities of the sites, all disturbed at once. Not only the peak counts: a later crest that a disturbance may
lift above it moves the answer as well (kernel.watch).
"""

from typing import NamedTuple

import numpy as np

from kernel.crests import moved, wins_late
from kernel.integrate import Peak
from kernel.jit import outer
from kernel.method import EXPLICIT, SINGLE_FROM, Integrator
from kernel.pairs import Pair, Rung, ScaledTask, apart, beside, bistable_peak, completed, crossings, noise_beside
from kernel.splitting.rules import REFERENCE_ACCURACY
from kernel.status import DONE

DISTURBANCE = 1e-6  # relative, of what the condition number is measured by
CHAOTIC = 1e3  # condition number from which a task is chaotic: its neighbours at 1e-6 differ by more than 1e-3
# A companion tells the condition number to a factor of four. Where it tells more than MEASURED_FROM, a fiftieth of
# CHAOTIC, the condition number is measured at the companion's steps, the cheaper ones. Where these give something
# between the last two numbers, a tenth to ten times CHAOTIC, it is measured once more, at the run's own steps; where
# they give more the task is flagged at once. Later rungs measure at the looser steps alone: of 413 chaotic ones among
# 6000 random tasks as many are found, of the others 0.2 % more are flagged at a target of 1e-3, no more at others, and
# certified tasks take 2 to 7 % less (tests.promises --random).
MEASURED_FROM, MEASURED_AGAIN_FROM, MEASURED_AGAIN_TO = 20.0, 100.0, 1e4
# By disturbances of these sizes, in DISTURBANCE. Where two crests change places the answer changes no further: what a
# larger disturbance tells is too little there. The smaller one has the other sign, and with it another draw of first
# velocities: what one disturbance leaves below the peak another one may lift above it. It is not asked in single
# precision, where rounding is nearly as large. How many chaotic tasks are found tells the column "flagged" of
# tests.promises --random.
LARGER, SMALLER = 2.0, -0.2
# How many times its change between two runs a crest may still grow in a third one: two runs of a chaotic crest show
# only two of its many values. Measured at 1e-3 on 700 random tasks: with 3, 4 the flag found 95, 98 % of the chaotic
# ones, and 1.2, 1.6 % of the calm ones (the columns "flagged" and "false" of tests.promises --random).
CREST_GROWTH = 3.0
# The disturbance that steps at an accuracy of REFERENCE_ACCURACY amount to, and the power of the accuracy with which it
# goes: medians that python -m tests.convergence prints.
DISTURBANCE_OF_STEPS, DISTURBANCE_POWER = 2.8e-5, 1.4
NEARLY = 0.95  # of the largest crest: another one may win in another run


class Early(NamedTuple):
    """The bistable chain's runs at the looser steps of the first rung, which are made before all others."""

    accuracy: float  # of these steps
    run: Peak
    disturbed: Peak  # `run` itself where none was asked for
    condition: float  # condition number of the bistable chain, which both tell; nan where there is one run only


class Measured(NamedTuple):
    """A condition number, and the ratios of the disturbed runs behind it; nan where there was none."""

    condition: float
    near: float
    farther: float


@outer
def equivalent_disturbance(accuracy: float) -> float:
    """The relative disturbance of the start that moves ke_ratio as much as the steps of this accuracy do.

    The median of random tasks with condition numbers of 20 to 1000; from task to task it varies by a factor of four.
    python -m tests.convergence prints it for every accuracy that a companion can have.
    """
    return DISTURBANCE_OF_STEPS * (accuracy / REFERENCE_ACCURACY) ** DISTURBANCE_POWER


@outer
def told(here: Pair, companion: Pair, accuracy: float) -> float:
    """The condition number that a run and its companion of this accuracy tell."""
    return max(1.0, apart(here, companion, CREST_GROWTH) / equivalent_disturbance(accuracy))


@outer
def wins_late_or_nearly(task: ScaledTask, peak: Peak) -> bool:
    """Whether a crest that comes later than sound crosses the chain wins, or nearly."""
    return wins_late(peak.crests, crossings(task), NEARLY)


@outer
def seen_early(task: ScaledTask, loose: Integrator, work: np.ndarray) -> Early:
    """Run the bistable chain at looser steps, and from a disturbed start where a late crest of it may be chaotic."""
    run = bistable_peak(task, 0.0, 0.0, loose, work, True)
    if run.run.status != DONE or run.method != EXPLICIT or not wins_late_or_nearly(task, run):
        return Early(loose.accuracy, run, run, np.nan)
    noise = noise_beside(task, run, DISTURBANCE)
    other = bistable_peak(task, DISTURBANCE, noise, loose, work, False)
    condition = moved(run.crests, other.crests, CREST_GROWTH) / DISTURBANCE if other.run.status == DONE else np.inf
    return Early(loose.accuracy, run, other, max(1.0, condition))


@outer
def condition_of(task: ScaledTask, rung: Rung, doubtful: bool, early: Early, work: np.ndarray) -> Measured:
    """The condition number: told by a run and the looser one, or measured where that is not small, or doubtful."""
    condition = told(rung.best, rung.against, rung.loose.accuracy)
    if doubtful or condition > MEASURED_FROM:
        return measured(task, rung, early, work)
    return Measured(condition, np.nan, np.nan)


@outer
def measured(task: ScaledTask, rung: Rung, early: Early, work: np.ndarray) -> Measured:
    """The condition number, by a looser run from a disturbed start, and a tighter one where that leaves it open."""
    is_first = early.accuracy == rung.loose.accuracy
    if is_first and early.condition > 0.0:
        there = completed(task, rung.against, early.disturbed, DISTURBANCE, rung.loose, work, False)
    else:
        there = beside(task, rung.against, DISTURBANCE, rung.loose, work, False)
    condition, farther = max(1.0, apart(rung.against, there, CREST_GROWTH) / DISTURBANCE), np.nan
    if is_first and MEASURED_AGAIN_FROM < condition < MEASURED_AGAIN_TO:
        condition, farther = measured_by(LARGER * DISTURBANCE, task, rung, work)
        if condition <= CHAOTIC and rung.integrator.accuracy < SINGLE_FROM:
            smaller, _ = measured_by(SMALLER * DISTURBANCE, task, rung, work)
            condition = max(condition, smaller)
    return Measured(condition, there.ratio, farther)


@outer
def measured_by(size: float, task: ScaledTask, rung: Rung, work: np.ndarray) -> tuple[float, float]:
    """The condition number by the run's own steps and one disturbance, and the disturbed run's ratio."""
    other = beside(task, rung.best, size, rung.integrator, work, False)
    return max(1.0, apart(rung.best, other, CREST_GROWTH) / abs(size)), other.ratio
