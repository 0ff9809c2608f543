"""What physics and accuracy decide: the steps of either scheme, and the bounds that no sound run crosses.

The numbers were measured on random tasks of the paper's domain against converged integrations: with them the error of
the peak energy is within the accuracy in 90 % of the well-conditioned tasks at the least cost. python -m tests.steps
multiplies one after the other and prints what that would miss and cost; what is said below of such multiples it told
at an accuracy of 1e-3 (--random 240 --seed 281128), where as they are 96 % of 325 chains are within it by the explicit
scheme and 95 % of 38 by the implicit one.
"""

import math
from typing import NamedTuple

from kernel.jit import jit
from kernel.model import Chain, tension

REFERENCE_ACCURACY = 1e-3  # accuracy at which the steps below are stated

# The explicit scheme. A step times the chain's largest frequency, and the power of the accuracy by which it grows. The
# scheme is stable below 3.13; THETA_MAX leaves room for a stiffness that grows within a step. With 1.2 times THETA 92 %
# are within the accuracy, with 0.85 times it 97 % at 1.12 times the cost.
THETA, THETA_POWER, THETA_MAX = 1.25, 0.4, 2.5
# Where a law's stiffness jumps, links pass the jump within steps, which leaves an error of second order in the step. At
# 0.4 a fifth more of 1000 lightly damped tasks miss 1e-3, not certified, and certified ones are no cheaper.
THETA_WHERE_IT_JUMPS = 0.3
# A step times the fastest rate at which dampers take energy, DAMPING_RATE zeta: as any explicit scheme, this one would
# blow up on longer ones. It shrinks with this power of the accuracy. From 0.7 to 4 times it the result is the same, at
# 0.99 to 1.02 times the cost.
DAMPED_STEP, DAMPING_RATE, DAMPED_POWER = 1.5, 8.0, 0.25
# A substep of the contact times its frequency; it goes with the square root of the accuracy, up to ETA_MAX, of which
# five fill a collision of Hertz's. Stable below 2. From 0.85 to 1.2 times it 95 to 96 % are within the accuracy, at
# 1.04 to 0.97 times the cost; with twice it one is off by 1500 accuracies.
ETA, ETA_MAX = 0.18, 0.8
# Substeps of one step, at the least, while impactor and chain are close, and the power of the accuracy by which they
# become fewer. From 0.85 to 1.4 times it 96 to 97 % are within the accuracy, at 0.99 to 1.02 times the cost, with half
# of it 83 %.
PARTS, PARTS_POWER = 16.0, -0.1
# Of a stiffness once seen, forgotten while sound crosses one unit cell. From 0.25 to 2 times it 95 to 96 % are within
# the accuracy, at 1.02 to 1 times the cost.
FADE = 0.1

# The implicit scheme, whose steps go with the square root of the accuracy. A step times the largest frequency, and a
# step, each with the longest that any accuracy asks for. From 0.85 to 4 times IMPLICIT_THETA the result is the same, at
# 1.02 to 0.96 times the cost; of IMPLICIT_STEP from 0.85 to 1.2 times, at 1.03 to 0.96 times.
IMPLICIT_THETA, IMPLICIT_THETA_LONGEST = 1.1, 1.5
IMPLICIT_STEP, IMPLICIT_STEP_LONGEST = 0.45, 0.6
# From damping ratio 1 on the dampers broaden the fronts, and implicit steps may be longer in proportion: at most
# BROADENING_MAX times, so that those of a companion run still are longer, and up to these. The springs are stable
# below a step of 2 over the largest frequency.
BROADENING_MAX, BROAD_THETA_MAX, BROAD_STEP_MAX = 1.6, 1.9, 0.9
# Of an undisturbed collision: the step at the first contact, and at a later opening or closing of the contact. From
# 0.25 to 1.2 times the first the result is the same, at 1.06 to 0.99 times the cost; of the second from 0.25 to 4
# times, at 1.14 to 0.9 times.
FIRST_STEP, EVENT_STEP = 0.03, 0.5
# A step over the time since the start, until the bounds above are reached: with 0.85 times it all are within the
# accuracy, at 1.05 times the cost, with 1.4 times 95 %, at 0.93 times, with twice it 89 %.
STEP_GROWTH = 0.04
# A step over the time to the next event, and since the last. From 0.25 to 4 times it the result is the same, at 1.16 to
# 0.91 times the cost: what it is for is the worst tasks, of which `implicit_rule` tells.
EVENT_SHARE = 0.5
COARSENING_MAX = 4.0  # times these steps are longer at the coarsest accuracies, at most
IMPLICIT_FADE = 0.2  # as FADE

ENERGY_GROWTH_MAX = 1.01  # energy at the end over energy at the start that still counts as sound
IMPLICIT_COARSEST = 1.8e-3  # accuracy from which on implicit steps, bounded by stability, hardly grow
# Period of a contact, at unit mass and energy 1/2, below which an open contact has shorter substeps: the paper's is
# above for any N. Without, of 2852 chains with contacts of 1e6 to 1e12 102 to 181 are off by more than five accuracies
# at targets of 1e-1 to 1e-3, with it 41 to 64, at 1.04 to 1.08 times the cost (python -m tests.hard_contacts
# --random 1500 --seed 91).
PERIOD_OF_PARTS = 2e-3
BISECTIONS = 40
WELL_SAMPLES = 64  # strains at which a well is looked for: the bounds are generous, its depth need not be exact
STRAIN_MAX = 1e6  # of a law that no strain can hold: some polynomials collapse
STRAIN_FACTOR = 1.2  # from one strain that is looked at to the next, on the way to one that holds the energy
# What no sound run passes: so many times the largest stiffness, and so much more, that the energy allows, and so many
# times the speed.
STIFFNESS_FACTOR, STIFFNESS_ADDED, SPEED_FACTOR = 1.2, 10.0, 2.0


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
    # Stiffness that steps resolve whatever the links' own; 0 where no well lies below rest. Where one does, links set
    # energy free and late crests grow: coarse steps do not show that they lose.
    least: float


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
    r = accuracy / REFERENCE_ACCURACY
    theta = THETA_WHERE_IT_JUMPS * math.sqrt(r) if chain.spring.stiffness_jumps() else THETA * r**THETA_POWER
    h_max = math.inf
    if chain.zeta > 0.0:
        h_max = min(1.0, r**DAMPED_POWER) * DAMPED_STEP / (DAMPING_RATE * chain.zeta)
    eta = whole_substeps(collision(chain), min(ETA_MAX, ETA * math.sqrt(r)))
    # Links may push the struck end back to the impactor within a substep of an open contact. The overlap found at its
    # end, whose energy comes from nowhere, goes as the square of the substep; that energy stays the same where overlaps
    # go as the contact's period. A substep whose overlap is deeper than that of a substep which resolves the contact is
    # made anew (kernel.splitting.zone).
    parts = PARTS * r**PARTS_POWER * math.sqrt(max(1.0, PERIOD_OF_PARTS / chain.contact.period(1.0, 0.5)))
    return ExplicitRule(min(THETA_MAX, theta), h_max, eta, parts, FADE)


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
    coarser = min(COARSENING_MAX, r)
    impact = chain.contact.duration(1.0 + 1.0 / chain.impactor_mass, V) * coarser
    theta = min(BROAD_THETA_MAX, min(IMPLICIT_THETA_LONGEST, IMPLICIT_THETA * r) * wide)
    h_max = min(BROAD_STEP_MAX, min(IMPLICIT_STEP_LONGEST, IMPLICIT_STEP * r) * wide)
    near_event = EVENT_SHARE * min(1.0, r)
    return ImplicitRule(theta, h_max, FIRST_STEP * impact, STEP_GROWTH * coarser, near_event, EVENT_STEP * impact)


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
def _strain_that_holds(chain: Chain, e: float, energy: float) -> float:
    """A strain, from e on, of a link that has this energy."""
    while chain.spring.energy_at(e) < energy and abs(e) < STRAIN_MAX:
        e *= STRAIN_FACTOR
    return e


@jit
def _strains_that_hold(chain: Chain, low: float, high: float, energy: float) -> tuple[float, float]:
    """A compression and a stretch, from these on, of a link that has this energy.

    A law that softens in tension is stretched further than it is compressed. It is taken for as much
    stretched as compressed, at the least, and where no stretch holds the energy, as of grains, which part.
    """
    low, high = _strain_that_holds(chain, low, energy), _strain_that_holds(chain, high, energy)
    return low, (max(high, -low) if high < STRAIN_MAX else -low)


@jit
def _deepest(chain: Chain, low: float, high: float) -> float:
    """The strain of the deepest well between these two; 0 where none lies below rest."""
    lowest, place = 0.0, 0.0
    for k in range(1, WELL_SAMPLES + 1):
        for e in (low * k / WELL_SAMPLES, high * k / WELL_SAMPLES):
            if chain.spring.energy_at(e) < lowest:
                lowest, place = chain.spring.energy_at(e), e
    return place


@jit
def _falling_stiffness(chain: Chain, well: float) -> float:
    """Largest f' that a link meets which falls from rest through this well and out of it again.

    It falls within a step that follows the stiffness which it has before.
    """
    e = well
    while chain.spring.energy_at(e) < 0.0 and abs(e) < STRAIN_MAX:
        e *= STRAIN_FACTOR
    return chain.spring.steepest(min(e, 0.0), max(e, 0.0))


@jit
def bounds(chain: Chain, V: float) -> Bounds:
    """From the energy of the impact and of the wells: the strains that would hold it all, and generous factors."""
    start = 0.5 * chain.impactor_mass * V * V
    low, high = _strains_that_hold(chain, -1.0, 1.0, start + 1.0)
    well = _deepest(chain, low, high) if low > -STRAIN_MAX else 0.0
    released = -chain.N * chain.spring.energy_at(well)  # what collapses is to be stopped
    low, high = _strains_that_hold(chain, low, high, start + released + 1.0)
    speed = SPEED_FACTOR * V * max(1.0, math.sqrt(chain.impactor_mass)) + SPEED_FACTOR * math.sqrt(2.0 * released)
    stiffness = STIFFNESS_FACTOR * chain.spring.steepest(low, high) + STIFFNESS_ADDED
    least = _falling_stiffness(chain, well) if well != 0.0 else 0.0
    return Bounds(stiffness, speed, ENERGY_GROWTH_MAX * start, least)


@jit
def link_and_site_energy(chain: Chain, e: float, v: float) -> float:
    """Energy of a link at strain e and of a site at speed v."""
    return 0.5 * v * v + chain.spring.energy_at(e)


@jit
def impactor_energy(chain: Chain, v: float, overlap: float) -> float:
    """Energy of the impactor at speed v and of the contact."""
    return 0.5 * chain.impactor_mass * v * v + chain.contact.energy_at(overlap)
