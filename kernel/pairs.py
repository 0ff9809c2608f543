"""Both chains of a task, run by one integrator, and how far two such pairs are apart."""

from typing import Any, NamedTuple

import numpy as np

from kernel.arrival import first_arrival_wins, may_be_sure
from kernel.crests import moved
from kernel.integrate import Peak, method_of, peak_of, told_by_modes
from kernel.jit import outer
from kernel.method import AUTO, EXPLICIT, EXTRAPOLATED, IMPLICIT, Integrator, at_accuracy, looser
from kernel.model import frequency_of, lattice_chain, linear_chain
from kernel.status import DONE, NOT_FINITE

# Where two runs of the bistable chain are extrapolated the linear chain's modes are so much tighter than what these
# tell: their errors, up to a tenth of an accuracy, then are no part of it, but for ERROR_OF_TIGHTEST (kernel.estimate).
AHEAD = 0.5

# What a disturbance of relative size 1 adds to zeta_T, as an undamped chain has no damping of which it could be a part:
# with one of 1e-6 a thousandth of the lightest damping that tests.truth draws.
DAMPING_DISTURBED = 1e-3

# Of the impact's speed. Where the watched site never gets as fast, first velocities are disturbed as much less: else
# what they are at this site would be taken for chaos, as it would with 2 / CHAOTIC or less here. With twice as much,
# rows of the paper's chain would change: the slowest middle site reaches 0.006 (of two sites, M_over_M0 = 0.01).
QUIET = 5e-3

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
def tighter_by(rung: Rung) -> float:
    """How many times tighter than the looser one a run is."""
    x, loose = rung.integrator, rung.loose
    return loose.accuracy / x.accuracy if loose.kind == AUTO else loose.rtol / x.rtol


@outer
def pair_of(task: ScaledTask, integrator: Integrator, work: np.ndarray, watched: bool) -> Pair:
    """Run both chains; work (3,): steps, (site) evaluations; watched: whether the task's quantities are looked at."""
    bistable = bistable_peak(task, 0.0, 0.0, integrator, work, watched)
    return paired(bistable, linear_peak(task, 0.0, 0.0, integrator, work, watched))


@outer
def beside(
    task: ScaledTask, pair: Pair, disturbance: float, integrator: Integrator, work: np.ndarray, watched: bool
) -> Pair:
    """A looser or disturbed pair to compare with `pair`.

    disturbance: relative, of impactor mass, speed and first velocities, below 0 by another draw of these (kernel.model,
    `disturb`); damping grows with it.
    """
    noise = noise_beside(task, pair.bistable, disturbance)
    bistable = bistable_peak(task, disturbance, noise, integrator, work, watched)
    return completed(task, pair, bistable, disturbance, integrator, work, watched)


@outer
def noise_beside(task: ScaledTask, peak: Peak, disturbance: float) -> float:
    """Size of the first velocities, over V, of a chain disturbed so much, whose undisturbed peak this is."""
    quiet = QUIET * task.V / frequency_of(task.lattice)
    return disturbance * peak.run.speed / quiet if peak.run.speed < quiet else disturbance


@outer
def completed(
    task: ScaledTask,
    pair: Pair,
    bistable: Peak,
    disturbance: float,
    integrator: Integrator,
    work: np.ndarray,
    watched: bool,
) -> Pair:
    """The pair of a bistable chain that has been run, with the linear chain of `pair` where that is sure.

    For the quantities a sure linear chain is run again all the same, as later crests may tell them.
    """
    linear, noise = pair.linear, noise_beside(task, pair.linear, disturbance)
    if not is_sure(task, linear):
        linear = linear_peak(task, disturbance, noise, integrator, work, watched)
    elif len(task.quantities) > 0 and watched:
        seen = linear_peak(task, disturbance, noise, integrator, work, watched)
        if seen.run.status != DONE:
            seen.largest[:] = np.nan
        linear = Peak(linear.run, linear.method, linear.KE, linear.crests, seen.largest)
    return paired(bistable, linear)


@outer
def disturbed(task: ScaledTask, disturbance: float) -> tuple[float, float, float]:
    """zeta_T, M and V of a run; V in the units of kernel.model."""
    more = 1.0 + disturbance
    return task.zeta_T + DAMPING_DISTURBED * abs(disturbance), task.M * more, task.V * more / frequency_of(task.lattice)


@outer
def bistable_peak(
    task: ScaledTask, disturbance: float, noise: float, integrator: Integrator, work: np.ndarray, watched: bool
) -> Peak:
    """Run the bistable chain alone; arguments as of `pair_of`, `beside`; noise: of `noise_beside`."""
    zeta_T, M, V = disturbed(task, disturbance)
    chain = lattice_chain(task.N, zeta_T, M, task.lattice)
    return counted(peak_of(chain, V, noise, integrator, task.quantities, watched), work)


@outer
def linear_peak(
    task: ScaledTask, disturbance: float, noise: float, integrator: Integrator, work: np.ndarray, watched: bool
) -> Peak:
    """Run the linear chain alone."""
    zeta_T, M, V = disturbed(task, disturbance)
    chain, x = linear_chain(task.N, zeta_T, M, task.lattice), for_linear(task, integrator)
    return counted(peak_of(chain, V, noise, x, task.quantities, watched), work)


@outer
def for_linear(task: ScaledTask, x: Integrator) -> Integrator:
    """What runs the linear chain beside a bistable one that x runs."""
    return auto_at(AHEAD * x.accuracy * x.accuracy / EXTRAPOLATED, x) if will_be_extrapolated(task, x) else x


@outer
def will_be_extrapolated(task: ScaledTask, x: Integrator) -> bool:
    """Whether the bistable chain's run is one of two that tell more together (kernel.extrapolate).

    Not where modes do not tell the linear chain.
    """
    chain = lattice_chain(task.N, task.zeta_T, task.M, task.lattice)
    implicit = method_of(chain.N, chain.zeta, chain.spring.is_linear(), x) == IMPLICIT
    return (
        implicit
        and told_by_modes(chain, task.V / frequency_of(task.lattice))
        and x.kind == AUTO
        and x.accuracy <= EXTRAPOLATED
        and not chain.spring.stiffness_jumps()
    )


@outer
def crossings(task: ScaledTask) -> float:
    """How many times sound crosses the chain in a run."""
    return float(task.lattice.t_end * frequency_of(task.lattice))


@outer
def is_sure(task: ScaledTask, linear: Peak) -> bool:
    """Whether the linear chain's peak is known to about an accuracy and its condition number is small.

    So it is where the crest of the first arrival wins by far, some sites from the struck end, by the explicit
    splitting, which loses its order where the contact's stiffness jumps. Modes can be five accuracies off where the
    impactor is as light as a few sites, and two hundred where the contact is far stiffer than the paper's, too.
    """
    chain = linear_chain(task.N, task.zeta_T, task.M, task.lattice)
    return linear.method == EXPLICIT and may_be_sure(chain) and first_arrival_wins(chain, linear.crests)


@outer
def counted(peak: Peak, work: np.ndarray) -> Peak:
    """The peak, and what its run took added to work (3,)."""
    work[0] += peak.run.steps
    work[1] += peak.run.evaluations
    work[2] += peak.run.site_evaluations
    return peak


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
