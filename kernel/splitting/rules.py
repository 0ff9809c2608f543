"""What physics and accuracy decide: the steps of either scheme, and the bounds that no sound run crosses.

The numbers were measured on random tasks of the paper's domain against converged integrations: with them the error of
the peak energy is within the accuracy in 90 % of the well-conditioned tasks at the least cost.
"""

import math
from typing import NamedTuple

from kernel.jit import jit
from kernel.model import Chain, tension

# From damping ratio 1 on the dampers broaden the fronts, and implicit steps may be longer in proportion: at most
# BROADENING_MAX times, so that those of a companion run still are longer.
BROADENING_MAX = 1.6
REFERENCE_ACCURACY = 1e-3  # accuracy at which the steps below are stated
ETA_MAX = 0.8  # substep of the contact times its frequency, the longest asked for: five fill a collision of Hertz's
# Where a law's stiffness jumps, links pass the jump within steps, which leaves an error of second order in the step. At
# 0.4 a fifth more of 1000 lightly damped tasks miss 1e-3, not certified, and certified ones are no cheaper.
THETA_WHERE_IT_JUMPS = 0.3
ENERGY_GROWTH_MAX = 1.01  # energy at the end over energy at the start that still counts as sound
IMPLICIT_COARSEST = 1.8e-3  # accuracy from which on implicit steps, bounded by stability, hardly grow
# Period of a contact, at unit mass and energy 1/2, below which an open contact has shorter substeps: the paper's is
# above for any N. Without, 28 of 500 linear chains struck with Hertz(1e12), lightly damped and at 2e-2, gained more
# than 1 % of energy in each of four tries; with it none does, at the same cost.
PERIOD_OF_PARTS = 2e-3
BISECTIONS = 40
WELL_SAMPLES = 64  # strains at which a well is looked for: the bounds are generous, its depth need not be exact
STRAIN_MAX = 1e6  # of a law that no strain can hold: some polynomials collapse


class ExplicitRule(NamedTuple):
    """Steps of the explicit scheme."""

    theta: float  # step times the largest frequency, 2 sqrt(f')
    h_max: float
    eta: float  # substep of the contact times its frequency; a whole number of them fills an undisturbed collision
    parts: float  # least number of substeps of one step while impactor and chain are close
    fade: float  # rate at which a stiffness once seen is forgotten


class ImplicitRule(NamedTuple):
    """Steps of the implicit scheme."""

    theta: float  # as above
    h_max: float
    first: float  # step at the first contact
    growth: float  # a later step over the time since the start
    near_event: float  # a step over the time to the next opening or closing of the contact, and since the last
    shortest: float  # step at such an event


class Bounds(NamedTuple):
    """What a run that has not blown up stays below."""

    stiffness: float  # of any link
    speed: float  # of the first and the middle site
    energy: float  # at the end


@jit
def collision(chain: Chain) -> float:
    """Duration of an undisturbed collision of impactor and first site times its largest frequency; of any speed."""
    mu = chain.impactor_mass / (1.0 + chain.impactor_mass)
    return chain.contact.duration(1.0 / mu, 1.0) / chain.contact.period(mu, 0.5 * mu)


@jit
def whole_substeps(duration: float, wanted: float) -> float:
    """The substep next to `wanted` of which a whole number fills a collision, all times its largest frequency.

    Leapfrog runs ahead: it is over the collision of a contact of any power earlier by the square of a substep over 8,
    to a tenth of that.
    """
    m = round(duration / wanted - 0.125 * wanted)
    return 4.0 * (math.sqrt(m * m + 0.5 * duration) - m)


@jit
def explicit_rule(chain: Chain, accuracy: float) -> ExplicitRule:
    """Steps for a wanted relative error of the peak energy. Dampers bound the step as in any explicit scheme.

    Leapfrog can be run backwards: a collision that a whole number of equal substeps fills ends as it began, with the
    right speeds, however long they are. The first collision, the hardest, is filled so where it ends well within a step
    of the chain: up to some hundred sites, and often beyond.
    """
    # theta: stable below 3.13, with a margin for a stiffness that grows within a step; eta: stable below 2
    r = accuracy / REFERENCE_ACCURACY
    theta = THETA_WHERE_IT_JUMPS * math.sqrt(r) if chain.spring.stiffness_jumps() else 1.25 * r**0.4
    h_max = min(1.0, r**0.25) * 1.5 / (8.0 * chain.zeta) if chain.zeta > 0.0 else math.inf
    eta = whole_substeps(collision(chain), min(ETA_MAX, 0.18 * math.sqrt(r)))
    # Links may push the struck end back to the impactor within a substep of an open contact. The overlap found at its
    # end, whose energy comes from nowhere, goes as the square of the substep; that energy stays the same where overlaps
    # go as the contact's period.
    parts = 16.0 * r**-0.1 * math.sqrt(max(1.0, PERIOD_OF_PARTS / chain.contact.period(1.0, 0.5)))
    return ExplicitRule(min(2.5, theta), h_max, eta, parts, 0.1)


@jit
def implicit_rule(chain: Chain, V: float, accuracy: float) -> ImplicitRule:
    """Steps for a wanted relative error of the peak energy. The first ones resolve the impact.

    Steps that pass over an opening or closing of the contact leave an error of what is left of the push, of first
    order: towards these events they shrink, the more the smaller the error is to be. Without, the worst of 434 random
    tasks was off by 25 accuracies at 1e-3 and 200 at 1e-6, with it by 2.5 and 3.1. What each method and chain is off by
    prints python -m tests.convergence --random.
    """
    r = math.sqrt(accuracy / REFERENCE_ACCURACY)
    wide = min(BROADENING_MAX, max(1.0, chain.zeta))
    impact = chain.contact.duration(1.0 + 1.0 / chain.impactor_mass, V) * min(4.0, r)
    theta = min(1.9, min(1.5, 1.1 * r) * wide)  # the springs are stable below 2
    h_max = min(0.9, min(0.6, 0.45 * r) * wide)
    return ImplicitRule(theta, h_max, 0.03 * impact, 0.04 * min(4.0, r), 0.5 * min(1.0, r), 0.5 * impact)


@jit
def held_stiffness(chain: Chain, lowest: float, highest: float, before: float, faded: float) -> float:
    """Largest f' on the chain, forgotten slowly: `faded` is the part of the one before that is forgotten.

    A step that follows the present stiffness is too long when the next front arrives: holding it cuts the worst errors
    tenfold at the same cost.
    """
    return max(chain.spring.steepest(lowest, highest), 1.0 + (before - 1.0) * max(0.0, 1.0 - faded))


@jit
def shock_stiffness(chain: Chain, V: float) -> float:
    """Largest f' behind the front that an impactor of speed V starts: e f(e) = V^2 (momentum and mass balance)."""
    low, high = 0.0, V + 1.0
    for _ in range(BISECTIONS):
        x = 0.5 * (low + high)
        if -x * tension(chain.spring, -x) < V * V:
            low = x
        else:
            high = x
    return chain.spring.steepest(-high, high)


@jit
def _strain_that_holds(chain: Chain, x: float, energy: float) -> float:
    """A compression, from x on, of a link that has this energy."""
    while chain.spring.energy_at(-x) < energy and x < STRAIN_MAX:
        x *= 1.2
    return x


@jit
def _deepest(chain: Chain, x: float) -> float:
    """What a link sets free that falls into the deepest well up to strain x; 0 where none lies below rest."""
    lowest = 0.0
    for k in range(1, WELL_SAMPLES + 1):
        e = x * k / WELL_SAMPLES
        lowest = min(lowest, chain.spring.energy_at(-e), chain.spring.energy_at(e))
    return -lowest


@jit
def bounds(chain: Chain, V: float) -> Bounds:
    """From the energy of the impact and of the wells: the strain that would hold it all, and generous factors."""
    start = 0.5 * chain.impactor_mass * V * V
    x = _strain_that_holds(chain, 1.0, start + 1.0)
    released = chain.N * _deepest(chain, x) if x < STRAIN_MAX else 0.0  # what collapses is to be stopped
    x = _strain_that_holds(chain, x, start + released + 1.0)
    speed = 2.0 * V * max(1.0, math.sqrt(chain.impactor_mass)) + 2.0 * math.sqrt(2.0 * released)
    return Bounds(1.2 * chain.spring.steepest(-x, x) + 10.0, speed, ENERGY_GROWTH_MAX * start)


@jit
def link_and_site_energy(chain: Chain, e: float, v: float) -> float:
    """Energy of a link at strain e and of a site at speed v."""
    return 0.5 * v * v + chain.spring.energy_at(e)


@jit
def impactor_energy(chain: Chain, v: float, overlap: float) -> float:
    """Energy of the impactor at speed v and of the contact."""
    return 0.5 * chain.impactor_mass * v * v + chain.contact.energy_at(overlap)
