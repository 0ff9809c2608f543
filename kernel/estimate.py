"""The error of a pair, from what it differs by from a looser one."""

from typing import Any

import numpy as np

from kernel.crests import wins_late
from kernel.jit import outer
from kernel.method import AUTO, EXPLICIT, FAR, IMPLICIT, NEAR, Integrator
from kernel.model import frequency_of
from kernel.pairs import Pair, ScaledTask, apart, auto_at, pair_of
from kernel.splitting.rules import IMPLICIT_COARSEST

# Which part of what a run differs by from a far looser one is its error: most of it is the looser one's. Two runs can
# agree by chance: the error is never believed to be below ERROR_PER_ACCURACY accuracies or ERROR_PER_RTOL relative
# tolerances, nor to fall faster from run to run than the accuracy does. python -m tests.convergence prints what other
# numbers would cover, and by how much.
SHARE_OF_FAR, ERROR_PER_ACCURACY, ERROR_PER_RTOL = 1.0 / 3.0, 0.3, 3.0
# Where a law's stiffness jumps, the explicit splitting loses its order, and what it differs by counts twice: of 651
# random tasks of a chain of straight pieces a third of it covered 87 %, the whole of it 93 %.
SHARE_WHERE_IT_JUMPS = 2.0
# Beyond IMPLICIT_COARSEST the implicit splitting's steps are bounded: a companion there is looser by little, and
# differs from the run by as much less. Of 2133 such random tasks at a target of 1e-2 the whole of it covers 94 %.
SHARE_WHERE_STEPS_ARE_BOUNDED = 2.5
# Where two runs may agree by chance a third is asked between or beyond them; at coarser steps than these a tighter
# one. With 1e-3 in its place, of 9700 random tasks 3 instead of one miss 1e-2 in silence, by more than five times.
COARSEST_DOUBTFUL = 3.5e-4
BETWEEN = 5.0  # times looser from which a companion counts as far
RTOL_STEP = 30.0  # how much tighter a refinement's tolerances are, where it is Dormand-Prince's


@outer
def share_of(spring: Any, here: Pair, loose: Integrator, integrator: Integrator) -> float:
    """Which part of what a run differs by from the one before, which was `loose`, is its error."""
    method = here.bistable.method
    share = SHARE_OF_FAR if tighter_by(loose, integrator) > BETWEEN else 1.0
    if loose.kind == AUTO and method == EXPLICIT and spring.stiffness_jumps():
        share = SHARE_WHERE_IT_JUMPS
    elif loose.kind == AUTO and method == IMPLICIT and loose.accuracy > IMPLICIT_COARSEST:
        share = SHARE_WHERE_STEPS_ARE_BOUNDED
    return share


@outer
def may_agree_by_chance(task: ScaledTask, here: Pair) -> bool:
    """Whether the explicit splitting told a crest that wins, or nearly, after sound has crossed the chain.

    Where dampers are weak, such a crest is the work of reflections and knocks: errors grow until two runs are equally
    far off. A third run is asked, and the condition number is measured.
    """
    t_end = task.lattice.t_end * frequency_of(task.lattice)  # in times that sound takes to cross the chain
    late = wins_late(here.bistable.crests, t_end) or wins_late(here.linear.crests, t_end)
    return here.bistable.method == EXPLICIT and late


@outer
def error_of(
    task: ScaledTask,
    best: Pair,
    against: Pair,
    loose: Integrator,
    integrator: Integrator,
    doubtful: bool,
    work: np.ndarray,
) -> float:
    """Estimated error of a pair, from the one before, which was `loose`; doubtful: these two may agree by chance."""
    error = share_of(task.lattice.spring, best, loose, integrator) * apart(best, against, 1.0)
    if doubtful and error <= integrator.target and integrator.accuracy <= COARSEST_DOUBTFUL:
        near = tighter_by(loose, integrator) < BETWEEN  # the third is far where the second is near, and near where far
        accuracy = integrator.accuracy * (FAR if near else NEAR)
        third = pair_of(task, 0.0, auto_at(accuracy, integrator), work, False)
        error = max(error, apart(best, third, 1.0) * (SHARE_OF_FAR if near else 1.0))
    return max(error, least_error(integrator))


@outer
def tighter_by(loose: Integrator, integrator: Integrator) -> float:
    """How many times tighter than `loose` a run is."""
    return loose.accuracy / integrator.accuracy if loose.kind == AUTO else loose.rtol / integrator.rtol


@outer
def least_error(x: Integrator) -> float:
    """The least error that is believed."""
    return ERROR_PER_ACCURACY * x.accuracy if x.kind == AUTO else ERROR_PER_RTOL * x.rtol
