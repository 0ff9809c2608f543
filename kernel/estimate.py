"""The error of a pair, from what it differs by from a looser one."""

import math

import numpy as np

from kernel.arrival import is_smooth
from kernel.condition import CREST_GROWTH, equivalent_disturbance, wins_late_or_nearly
from kernel.extrapolate import is_regular
from kernel.jit import outer
from kernel.linear import TIGHTEST
from kernel.method import AUTO, DORMAND_PRINCE, EXPLICIT, EXTRAPOLATED, FAR, IMPLICIT, MODES, NEAR, Integrator
from kernel.pairs import Rung, ScaledTask, apart, auto_at, beside, for_linear, is_sure, tighter_by
from kernel.splitting.rules import IMPLICIT_COARSEST, REFERENCE_ACCURACY

# Of what a run and a far looser one differ by, most is the looser one's error; only this share counts as the run's own.
# Two runs can agree by chance: the error is never believed to be below ERROR_PER_ACCURACY accuracies or ERROR_PER_RTOL
# relative tolerances, nor to fall faster from run to run than the accuracy does. python -m tests.convergence prints
# what other numbers would cover, and by how much.
SHARE_OF_FAR, ERROR_PER_ACCURACY, ERROR_PER_RTOL = 1.0 / 3.0, 0.3, 3.0
# Accuracy above which steps are coarse: errors do not fall regularly yet, and where two runs may agree by chance a
# tighter one is asked for. Below it a third is, between or beyond them. With 1e-3 in its place, of 9700 random tasks 3
# instead of one miss 1e-2 in silence, by more than five times.
COARSE = 3.5e-4
# At finer steps the errors of the explicit splitting are proportional to the accuracy. A run that is r times tighter
# than another then has 1 / (r - 1) of their difference as its error; MARGIN times that is told, and at least
# LEAST_OF_FINE accuracies. Of 4400 random tasks at targets of 1e-3 to 1e-6 this covers 98.5 to 99.4 % of the errors and
# is 8 to 12 times as large in the median; twice the margin covers 99 to 99.8 % and is 11 to 16 times as large. A third
# run has a margin of its own; with MARGIN for it, too, 0.3 % less is covered. python -m tests.promises --random tells
# it anew.
MARGIN, MARGIN_OF_THIRD, LEAST_OF_FINE = 1.5, 2.2, 0.2
# Steps act on a task as a disturbance of its start does (kernel.condition, `equivalent_disturbance`). An explicit run
# is never believed to be off by less than STEPS_FELT times what that one does: of the tasks above two of the seven that
# missed five targets in silence are found so, at the price of one more refinement in a thousand tasks.
STEPS_FELT = 2.0
# Of runs that are extrapolated so much of the better one's own error counts at an accuracy of EXTRAPOLATED, and so much
# of the accuracy is the least that is believed. With the accuracy the share falls, as what is left is of twice the
# order, and the least faster, by this power. Of 1200 random damped tasks 98 % are covered at targets of 1e-4 to 1e-7.
SHARE_OF_EXTRAPOLATED, LEAST_OF_EXTRAPOLATED, LEAST_POWER = 0.5, 0.12, 1.5
# What a sure linear chain, which is run once, may be off by, in accuracies at REFERENCE_ACCURACY, and the power of the
# accuracy by which these become fewer. How many chains are within it tells python -m tests.convergence; with 0.4 and
# 0.6, `error` of 2951 random tasks covers 97.5 and 98.5 % at a target of 1e-2.
LINEAR_ERROR, LINEAR_POWER = 0.5, 0.25
# What modes may be off by, relative, where they are asked for more than TIGHTEST. Their steps get no shorter then, so
# that a looser run, of nearly the same steps, does not tell it. Nor would shorter ones help: doubled tables carry on
# what the shortest step's are rounded by, and between the nodes of grouped modes as much is left, some 1e-9. It is
# independent of what else is told, hence added in squares. At a target of 1e-8 `error` of three sets of 200 to 300
# random tasks with N zeta_T above 0.4 then covers 99 to 99.7 %, with 4e-9 96 to 98 %, without 81 to 91 %
# (python -m tests.tightest).
ERROR_OF_TIGHTEST = 6e-9
# Where a law's stiffness jumps, errors of the explicit splitting do not fall regularly, and all that it differs by
# counts: of 370 tasks of straight pieces that covers 98 % at 1e-3 and 1e-4, but 94 % at 1e-2, where stability bounds
# the looser steps of damped chains; of a far looser run a third of it covers 95 %. So it is where the stiffness of the
# contact jumps: of 415 chains of grains with a contact of exponent 1 to 1.17 it covers 98.8 % at 1e-4, 89 % without.
SHARE_WHERE_IT_JUMPS, SHARE_WHERE_IT_JUMPS_FAR = 2.0, 1.0
# The steps of Dormand-Prince follow the error: two runs differ by what both are off by, at random. Of 785 random tasks
# at a target of 1e-6 so much of what a companion of four times the rtol differs by covers 97 %, 19 times as large as
# the error in the median; of sixteen times the rtol the whole covers 98 %, 40 times as large, a third 92 %.
SHARE_AT_RANDOM, SHARE_AT_RANDOM_FAR = 1.5, 1.0
# Beyond IMPLICIT_COARSEST the implicit splitting's steps are bounded: a companion there is looser by little, and
# differs from the run by as much less. Of 949 such random tasks at a target of 1e-2 2.5 times it covers 95 to 98 %,
# five times it 99 %, for a tighter run in one or two of a hundred.
SHARE_WHERE_STEPS_ARE_BOUNDED = 4.0
BETWEEN = 5.0  # times looser from which a companion counts as far
RTOL_STEP = 30.0  # how much tighter a refinement's tolerances are, where it is Dormand-Prince's


@outer
def share_of(task: ScaledTask, rung: Rung) -> float:
    """Which part of what a run differs by from the looser one counts as its error.

    Of two runs that are extrapolated a part of the better one's own: what is left of it is far less.
    """
    best, share = rung.best.bistable.method, SHARE_OF_FAR if is_far(rung) else 1.0
    if best == DORMAND_PRINCE:
        share = SHARE_AT_RANDOM_FAR if is_far(rung) else SHARE_AT_RANDOM
    elif is_regular(task, rung):
        share = SHARE_OF_EXTRAPOLATED * gained(rung.integrator) / (tighter_by(rung) - 1.0)
    elif best == EXPLICIT and has_a_jump(task):
        share = SHARE_WHERE_IT_JUMPS_FAR if is_far(rung) else SHARE_WHERE_IT_JUMPS
    elif is_fine_explicit(task, rung):
        share = MARGIN / (tighter_by(rung) - 1.0)
    elif best == IMPLICIT and rung.loose.accuracy > IMPLICIT_COARSEST:
        share = SHARE_WHERE_STEPS_ARE_BOUNDED
    return share


@outer
def may_agree_by_chance(task: ScaledTask, rung: Rung) -> bool:
    """Whether the explicit splitting told a crest that wins, or nearly, after sound has crossed the chain.

    Where dampers are weak, reflections and new contacts make such a crest. Errors grow on the way, until two runs can
    be off by the same amount. Then two precautions are taken on the first rung: the condition number is measured,
    and a third run is made.
    """
    best = rung.best
    late = wins_late_or_nearly(task, best.bistable) or wins_late_or_nearly(task, best.linear)
    return best.bistable.method == EXPLICIT and late


@outer
def error_of(task: ScaledTask, rung: Rung) -> float:
    """Estimated error of a run, from the looser one. Where dampers are weak another crest than the largest may grow."""
    change = apart(rung.best, rung.against, CREST_GROWTH if rung.best.bistable.method == EXPLICIT else 1.0)
    error = share_of(task, rung) * change + error_alone(task, rung)
    error = max(error, least_error(task, rung))
    return math.hypot(error, ERROR_OF_TIGHTEST) if beyond_tightest(task, rung) else error


@outer
def error_alone(task: ScaledTask, rung: Rung) -> float:
    """What is added for a linear chain that no other run of the rung is compared with."""
    return linear_error(rung.integrator.accuracy) if is_sure(task, rung.best.linear) else 0.0


@outer
def beyond_tightest(task: ScaledTask, rung: Rung) -> bool:
    """Whether modes told the linear chain that were asked for more than they can."""
    return rung.best.linear.method == MODES and for_linear(task, rung.integrator).accuracy < TIGHTEST


@outer
def linear_error(accuracy: float) -> float:
    """What a linear chain whose peak is sure may be off by."""
    return LINEAR_ERROR * accuracy * (accuracy / REFERENCE_ACCURACY) ** LINEAR_POWER


@outer
def error_by_third(task: ScaledTask, rung: Rung, work: np.ndarray) -> float:
    """Estimated error of a run, from a third: near it where the second is far, and far where that is near."""
    x = rung.integrator
    third = auto_at(x.accuracy * (NEAR if is_far(rung) else FAR), x)
    change = apart(rung.best, beside(task, rung.best, 0.0, third, work, False), CREST_GROWTH)
    return MARGIN_OF_THIRD / (third.accuracy / x.accuracy - 1.0) * change + error_alone(task, rung)


@outer
def error_felt(rung: Rung, condition: float) -> float:
    """What the steps of an explicit run do at least to a task of this condition number."""
    if rung.best.bistable.method != EXPLICIT or not condition < np.inf:
        return 0.0
    return STEPS_FELT * condition * equivalent_disturbance(rung.integrator.accuracy)


@outer
def is_fine_explicit(task: ScaledTask, rung: Rung) -> bool:
    """Whether both runs are the explicit splitting's, at steps so fine that errors are proportional to the accuracy."""
    both = rung.best.bistable.method == EXPLICIT and rung.against.bistable.method == EXPLICIT
    return both and rung.integrator.accuracy <= COARSE and not has_a_jump(task)


@outer
def has_a_jump(task: ScaledTask) -> bool:
    """Whether a stiffness jumps, of the springs or of the contact, as of one whose force is as its overlap."""
    return bool(task.lattice.spring.stiffness_jumps() or not is_smooth(task.lattice.contact.of_cells(task.N)))


@outer
def is_far(rung: Rung) -> bool:
    """Whether the looser run is so much looser that its own error is most of what they differ by."""
    return tighter_by(rung) > BETWEEN


@outer
def gained(x: Integrator) -> float:
    """How many times less is left of two runs that are extrapolated than of one."""
    return x.accuracy / EXTRAPOLATED


@outer
def least_error(task: ScaledTask, rung: Rung) -> float:
    """The least error that is believed."""
    x = rung.integrator
    if is_regular(task, rung):
        return LEAST_OF_EXTRAPOLATED * x.accuracy * gained(x) ** LEAST_POWER
    if is_fine_explicit(task, rung):
        return LEAST_OF_FINE * x.accuracy
    return ERROR_PER_ACCURACY * x.accuracy if x.kind == AUTO else ERROR_PER_RTOL * x.rtol
