"""The comparative linear chain where the dampers are strong: only its contact is nonlinear, so its modes are exact.

High modes are grouped. Everything is scaled to impact speed 1, as KE/TE depends on the speed through the contact only.
"""

import math
from typing import Any

from kernel.jit import jit
from kernel.linear import modes
from kernel.linear.spectrum import chain_modes
from kernel.model import Array, Chain
from kernel.run import Run
from kernel.splitting.rules import REFERENCE_ACCURACY
from kernel.status import DONE, NOT_FINITE

# Accuracies beyond these are taken as these. What is left at the tightest: kernel.estimate, ERROR_OF_TIGHTEST.
TIGHTEST, LOOSEST = 1e-8, 1e-2
# Largest force of the first collision, over V and the impedance of unit springs and masses, up to which modes serve a
# chain. Their steps follow the contact's force, but not where it is a small part of this one (modes.FORCE_MIN): of
# contacts so hard that the first collision is over in no time they pass over the pushes that move the chain. Of 503
# random tasks with contacts of all exponents, 3 of 297 below are off by more than an accuracy, by 3.4 at most, at 1e-2
# to 1e-4; a fifth of those above are, by up to 650. Of 419 of a later seed none of 247 below 530 is off by more than
# half an accuracy (no program repeats this; tests/test_kernel_linear.py asks fewer). The paper's contact reaches 529
# (N = 2, M/M0 = 100, V/V0 = 20).
HARDEST = 600.0
ENERGY_ROUNDING = 1e-6  # of the initial energy: so much more at the end is no gain of energy
# Steps at the accuracy of REFERENCE_ACCURACY, and the powers of the accuracy by which they change: bends of the contact
# force and of the watched site's velocity that one step may leave (modes.UnitImpact), and first steps of one collision.
# python -m tests.steps multiplies one after the other. With them the largest error of 57 random chains at 1e-3 is 0.11
# accuracies. FORCE_BEND is what it goes by: with four times it 0.43, at 0.66 times the cost, and modes are cheap beside
# the bistable chain. From 0.25 to 4 times SPEED_BEND, and from 0.85 to 2 times STEPS_PER_COLLISION and from 0.5 to 4
# times LONGEST_STEP, it stays between 0.08 and 0.14, at 0.98 to 1.06 times the cost.
FORCE_BEND, FORCE_POWER = 0.01, 0.9
SPEED_BEND, SPEED_POWER = 0.1, 0.4
STEPS_PER_COLLISION, STEPS_POWER = 64.0, -0.45
LONGEST_STEP = 0.1  # of the time in which sound crosses the chain


@jit
def is_soft_enough(chain: Chain, V: float) -> bool:
    """Whether modes can follow the contact of an impact at speed V (HARDEST)."""
    mu = chain.impactor_mass / (1.0 + chain.impactor_mass)
    return bool(math.pi * mu <= HARDEST * chain.contact.at_unit_speed(V).duration(1.0 / mu, 1.0))


@jit
def impact_of(chain: Chain, contact: Any, accuracy: float) -> modes.UnitImpact:
    """The impact, and the steps for a wanted relative error of the peak energy; contact: the law at unit speed."""
    r = min(max(accuracy, TIGHTEST), LOOSEST) / REFERENCE_ACCURACY
    bends = FORCE_BEND * r**FORCE_POWER, SPEED_BEND * r**SPEED_POWER
    steps = STEPS_PER_COLLISION * r**STEPS_POWER
    return modes.UnitImpact(contact, chain.impactor_mass, bends[0], bends[1], steps, LONGEST_STEP * chain.N)


@jit
def run_modes(chain: Chain, V: float, accuracy: float, max_steps: int, crests: Array) -> Run:
    """One impact at speed V on a linear chain; the law of its springs does not count.

    accuracy: of the kinetic energy, 1e-2 .. 1e-8; crests: as of kernel.watch.Watch; quantities are not looked at, as
    only the watched site and the contact are known.
    Right at any damping, but its steps and its modes are few only where the dampers are strong.
    """
    contact, t_end = chain.contact.at_unit_speed(V), chain.t_end
    if not math.isfinite(chain.zeta + chain.impactor_mass + contact.push(1.0) + accuracy):
        return Run(NOT_FINITE, math.nan, math.nan, 0, 0, 0, math.nan, 0)
    impact = impact_of(chain, contact, accuracy)
    exact = chain_modes(chain.N, chain.zeta, chain.site)
    status, steps, speed, t = modes.march(exact, chain.zeta, impact, t_end, max_steps, crests)
    crests *= V
    sites = steps * exact.number
    if status == DONE and not speed * speed / chain.impactor_mass <= 1.0 + ENERGY_ROUNDING:
        status = NOT_FINITE
    return Run(status, speed * V, t, steps, sites // chain.N, sites, math.nan, 0)
