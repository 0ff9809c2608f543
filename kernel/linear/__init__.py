"""The comparative linear chain where the dampers are strong: only its contact is nonlinear, so its modes are exact.

High modes are grouped. Everything is scaled to impact speed 1, as KE/TE depends on the speed through the
contact only.
"""

import math
from typing import Any, NamedTuple

from kernel.crests import part_of
from kernel.jit import jit
from kernel.linear import modes
from kernel.linear.peak import scattered_peak
from kernel.linear.spectrum import chain_modes
from kernel.method import RETRIES, RETRY_TIGHTER
from kernel.model import T_END_OVER_N, Array, Chain
from kernel.simd import flush_subnormals, restore_subnormals
from kernel.status import DONE, NOT_FINITE

TIGHTEST, LOOSEST = 1e-8, 1e-2  # accuracies beyond these are taken as these


class LinearPeak(NamedTuple):
    """What one run tells, in the units of kernel.model."""

    status: int  # kernel.status code: DONE, NOT_FINITE, STEP_BUDGET
    speed: float  # max |v_mid| over continuous time in [0, 2.25 N]
    t: float  # when
    steps: int  # that resolve the contact, retries included
    site_evaluations: int  # steps of a mode


@jit
def _attempt(chain: Chain, contact: Any, accuracy: float, max_steps: int, crests: Array) -> LinearPeak:
    """One run at impact speed 1; contact: its law at this speed."""
    coarser, t_end = accuracy / 1e-3, T_END_OVER_N * chain.N
    impact = modes.Impact(
        contact,
        chain.impactor_mass,
        0.01 * coarser ** (2.0 / 3.0),
        0.1 * coarser**0.3,
        64.0 * coarser ** (-1.0 / 3.0),
        0.1 * chain.N,
    )
    exact = chain_modes(chain.N, chain.zeta)
    status, steps, count, times, speeds = modes.march(exact, chain.zeta, impact, t_end, max_steps)
    square, t = scattered_peak(times, speeds, count, t_end)
    crests[:] = 0.0
    for i in range(count):
        if times[i] < t_end:
            part = part_of(times[i], t_end)
            crests[part] = max(crests[part], abs(speeds[i]))
    crests[part_of(t, t_end)] = math.sqrt(square)
    return LinearPeak(status, math.sqrt(square), t, steps, steps * exact.number)


@jit
def checked(status: int, KE_over_TE: float) -> int:
    """A site cannot have more than all the energy: a run that says so, or nan, blew up."""
    return NOT_FINITE if status == DONE and not KE_over_TE <= 1.0 + 1e-6 else status


@jit
def linear_peak(chain: Chain, V: float, accuracy: float, max_steps: int, crests: Array) -> LinearPeak:
    """Peak speed of the middle site of a linear chain struck at speed V; the law of its springs does not count.

    accuracy: of the kinetic energy, 1e-2 .. 1e-8. crests (PARTS,): receives the largest |v_mid| of each part of the
    run, exact where the peak is, of the steps' ends elsewhere. A pure function of its arguments. Right at
    any damping, but its steps and its modes are few only where the dampers are strong.
    """
    contact = chain.contact.at_unit_speed(V)
    if not math.isfinite(chain.zeta + chain.impactor_mass + contact.push(1.0) + accuracy):
        return LinearPeak(NOT_FINITE, math.nan, math.nan, 0, 0)
    accuracy = min(max(accuracy, TIGHTEST), LOOSEST)
    word, tries, steps, sites = flush_subnormals(), 0, 0, 0
    while True:
        run = _attempt(chain, contact, accuracy, max_steps - steps, crests)
        steps, sites, tries = steps + run.steps, sites + run.site_evaluations, tries + 1
        status = checked(run.status, run.speed * run.speed / chain.impactor_mass)
        if status != NOT_FINITE or tries > RETRIES:
            break
        accuracy = max(accuracy / RETRY_TIGHTER, TIGHTEST)
    restore_subnormals(word)
    crests *= V
    return LinearPeak(status, run.speed * V, run.t, steps, sites)
