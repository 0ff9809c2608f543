"""The error of a pair, from what it differs by from a looser one."""

from typing import Any

import numpy as np

from kernel.crests import wins_late
from kernel.jit import outer
from kernel.method import AUTO, COMPANION_ACCURACY, EXPLICIT, IMPLICIT, RK45, Integrator
from kernel.model import frequency_of
from kernel.pairs import Pair, ScaledTask, apart, companion_of, pair_of
from kernel.splitting.rules import IMPLICIT_COARSEST

# What Dormand-Prince differs by from a looser run is mostly that run's error; its own is at least three times smaller.
# Two runs can agree by chance: the error is never believed to be below ERROR_PER_ACCURACY accuracies or ERROR_PER_RTOL
# relative tolerances, nor to fall faster from run to run than the accuracy does. python -m tests.convergence prints
# what other numbers would cover, and by how much.
RK45_SHARE, ERROR_PER_ACCURACY, ERROR_PER_RTOL = 1.0 / 3.0, 0.3, 3.0
# Where a law's stiffness jumps, the explicit splitting loses its order, and what it differs by counts twice: of 651
# random tasks of a chain of straight pieces a third of it covered 87 %, the whole of it 93 %.
SHARE_WHERE_IT_JUMPS = 2.0
# Beyond IMPLICIT_COARSEST the implicit splitting's steps are bounded: a companion there is looser by little, and
# differs from the run by as much less. Of 2133 such random tasks at a target of 1e-2 the whole of it covers 94 %.
SHARE_WHERE_STEPS_ARE_BOUNDED = 2.5
# Where two runs may agree by chance a third is asked, looser still; at coarser steps than these a tighter one. With
# 1e-3 in its place 1e-2 is missed in silence, by more than five times, by 3 of 9700 random tasks instead of by one.
COARSEST_DOUBTFUL = 3.5e-4
RTOL_STEP = 30.0  # how much tighter a refinement's tolerances are, where it is Dormand-Prince's


@outer
def share_of(spring: Any, here: Pair, loose: Integrator) -> float:
    """Which part of what a run differs by from the one before, which was `loose`, is its error."""
    method, share = here.bistable.method, 1.0
    if loose.kind == RK45:
        share = RK45_SHARE
    elif method == EXPLICIT and spring.stiffness_jumps():
        share = SHARE_WHERE_IT_JUMPS
    elif method == IMPLICIT and loose.accuracy > IMPLICIT_COARSEST:
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
    error = share_of(task.lattice.spring, best, loose) * apart(best, against, 1.0)
    if doubtful and error <= integrator.target and integrator.accuracy <= COARSEST_DOUBTFUL:
        third = pair_of(task, 0.0, companion_of(loose), work, False)
        error = max(error, apart(best, third, 1.0) / fall_to(loose))
    return max(error, least_error(integrator))


@outer
def fall_to(loose: Integrator) -> float:
    """How many times tighter than `loose` the next run is, and so how many times smaller its error may be."""
    return COMPANION_ACCURACY if loose.kind == AUTO else RTOL_STEP


@outer
def least_error(x: Integrator) -> float:
    """The least error that is believed."""
    return ERROR_PER_ACCURACY * x.accuracy if x.kind == AUTO else ERROR_PER_RTOL * x.rtol
