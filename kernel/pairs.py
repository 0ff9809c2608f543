"""Both chains of a task, run by one integrator, and how far two such pairs are apart."""

from typing import Any, NamedTuple

import numpy as np

from kernel.crests import moved
from kernel.integrate import Peak, peak_of
from kernel.jit import outer
from kernel.method import Integrator, at_accuracy, looser
from kernel.model import frequency_of, lattice_chain, linear_chain
from kernel.status import DONE, NOT_FINITE

companion_of, auto_at = outer(looser), outer(at_accuracy)


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


class Rung(NamedTuple):
    """A run, and the looser one that it is compared with."""

    best: Pair
    integrator: Integrator
    against: Pair
    loose: Integrator


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
