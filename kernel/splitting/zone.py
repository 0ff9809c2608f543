"""The struck end while impactor and chain touch: sites 0..m once more, with small steps, over one step of the chain.

Leapfrog with kicks in the middle of its substeps. The velocity of site m+1 is the cubic Hermite polynomial of the
chain's step. That step carried information over no more than 7 sites (one per kick and drift), so beyond them the chain
has not missed the contact: only the first SITES_KEPT sites are taken over, and the rest of the zone is a margin.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from kernel.jit import jit
from kernel.model import Array, Chain
from kernel.simd import DOUBLE, WIDTH, element, left_neighbours, load, load_doubles, right_neighbours, splat, store
from kernel.splitting.rules import ExplicitRule
from kernel.splitting.sweeps import Pack, acceleration, row
from kernel.watch import asks_for_push

ZONE_SITES = 16  # of the zone
SITES_KEPT = 8  # of which so many are taken over
SUBSTEPS_PER_LOOK = 32  # substeps between two looks at the contact's frequency
SUBSTEPS_AHEAD = 1.5  # substeps before the gap can close they become small
# A gap counts as closed within a step where it becomes smaller than this part of what it opens by in one step at the
# rate of the step's end: the cubic polynomial between both ends tells it no better.
GAP_CLOSED = 1e-3
SUBSTEP_MIN = 1e-12  # of a step: substeps below it mean that the state has blown up
ROUNDING = 1e-9  # of a step
EXTREMUM_MIN = 0.7  # an extremum below this part of the best so far is not looked at


class Zone(NamedTuple):
    """A copy of the struck end, in the layout of kernel.splitting.sweeps."""

    e: Array
    v: Array
    m: int  # sites
    mask: Array  # (24,): 1 for the sites of both packs that belong to the chain, else 0; then 1 for site 1


class Border(NamedTuple):
    """Velocity of the site beyond the zone during a step: v + x (p1 + x (p2 + x p3)), x the fraction of the step."""

    v: float
    p1: float
    p2: float
    p3: float


@jit
def new_zone(N: int) -> Zone:
    """Of a chain of N sites. A chain that is not longer lies wholly in its zone."""
    m = min(N, ZONE_SITES)
    mask = np.zeros(ZONE_SITES + WIDTH)
    mask[:m] = mask[ZONE_SITES] = 1.0
    return Zone(row(m, DOUBLE), row(m, DOUBLE), m, mask)


@jit
def copy_from(near_e: Array, near_v: Array, e: Array, v: Array) -> None:
    """Remember the struck end of the chain as it is before a step."""
    near_e[0], near_v[0] = e[0], v[0]
    for i in range(1, ZONE_SITES + 1, WIDTH):
        store(near_e, i, load_doubles(e, i))
        store(near_v, i, load_doubles(v, i))


@jit
def copy_to(zone: Zone, closed: bool, e: Array, v: Array) -> None:
    """Let the chain take over what is right of the zone."""
    sites = zone.m if closed else SITES_KEPT
    links = zone.m if closed else SITES_KEPT - 1
    for i in range(sites + 1):
        v[i] = zone.v[i]
    for i in range(links + 1):
        e[i] = zone.e[i]


@jit
def touches(gap0: float, gap1: float, rate0: float, rate1: float, h: float) -> bool:
    """Whether the gap closes in a step without contact, from the gap and its rate at both ends (cubic Hermite)."""
    if gap0 < 0.0 or gap1 < 0.0:
        return True
    if not (rate0 < 0.0 and rate1 > 0.0):
        return False
    s, d = rate0 / (rate0 - rate1), gap1 - gap0
    lowest = gap0 + s * (h * rate0 + s * (3.0 * d - h * (2.0 * rate0 + rate1) + s * (h * (rate0 + rate1) - 2.0 * d)))
    return lowest < GAP_CLOSED * h * rate1


@jit
def beyond(chain: Chain, e: Array, v: Array, m: int) -> tuple[float, float]:
    """Velocity and acceleration of the site beyond a zone of m sites."""
    return np.float64(v[m + 1]), acceleration(chain, e, v, m + 1)


@jit
def border_between(h: float, v0: float, v1: float, a0: float, a1: float) -> Border:
    """From the velocities and accelerations of the site beyond the zone at both ends of a step."""
    return Border(v0, h * a0, 3.0 * (v1 - v0) - h * (2.0 * a0 + a1), -2.0 * (v1 - v0) + h * (a0 + a1))


@jit
def contact_period(chain: Chain, overlap: float, approach: float) -> float:
    """One over the largest frequency of a contact with the energy that it has now."""
    mu = chain.impactor_mass / (1.0 + chain.impactor_mass)
    return chain.contact.period(mu, 0.5 * mu * approach * approach + chain.contact.energy_at(overlap))


@jit
def _substep(
    chain: Chain, overlap: float, approach: float, rule: ExplicitRule, free: float, fine: float
) -> tuple[float, float]:
    """Next substep (at most `free`), and the one that resolves the contact (or -1); fine: the latter as it was."""
    if not (overlap > 0.0 or (approach > 0.0 and -overlap < SUBSTEPS_AHEAD * approach * free)):
        return free, -1.0
    if fine < 0.0 or overlap > 0.0:
        fine = rule.eta * contact_period(chain, overlap, approach)
    h = min(fine, free)
    if overlap < 0.0:
        h = min(free, max(h, -overlap / approach))  # to where the gap closes
    return h, fine


@jit
def _is_found_too_late(
    chain: Chain, overlap: float, approach: float, rule: ExplicitRule, dt: float, fine: float
) -> bool:
    """Whether a substep of an open contact ends deeper in it than one that resolves the contact, `fine`, gets.

    So it does where links push the struck end onto the impactor. The overlap's energy then comes from nowhere.
    """
    if not overlap > 0.0:
        return False
    resolving = rule.eta * contact_period(chain, overlap, approach)
    return dt > max(fine, resolving) and overlap > approach * resolving


@jit
def _equal(dt: float, left: float, most: int) -> tuple[float, int]:
    """How many substeps of which size, dt at most, come next: `most`, or as many as fill the time left."""
    if most * dt < left * (1.0 - ROUNDING):
        return dt, most
    count = math.ceil(left / dt * (1.0 - ROUNDING))
    return left / count, count


@jit
def _bend(h: float, v: float, a0: float, a1: float) -> float:
    """|v| at its maximum if it lies between the middles of two substeps with accelerations a0, a1, else 0."""
    if a0 * a1 >= 0.0 or v * a0 <= 0.0:
        return 0.0
    return abs(v) + 0.25 * h * abs(a1 * a0) / (abs(a1) + abs(a0))


@jit
def _fastest(
    best: float, t_best: float, v0: float, v1: float, a0: float, a1: float, t: float, dt: float
) -> tuple[float, float]:
    """The largest |v| and its time, after the substep that ends at t with velocity v1; v0, a0: of the one before."""
    bend = _bend(dt, v0, a0, a1)
    if abs(v1) > best:
        best, t_best = abs(v1), t
    if abs(v0) > EXTREMUM_MIN * best and bend > best:
        best, t_best = bend, t - dt
    return best, t_best


@jit
def _tension(chain: Chain, e: Pack, rate: Pack) -> Pack:
    """Tension of eight links at strain e, the dampers at `rate`."""
    return chain.spring.excess(e) + (2.0 * chain.zeta * rate + e)


@jit
def resolve(
    chain: Chain,
    e: Array,
    v: Array,
    mask: Array,
    rule: ExplicitRule,
    border: Border,
    h: float,
    watched: int,
    best: float,
    quantities: Any,
) -> tuple[int, float, float, float, float]:
    """Integrate the zone (e, v, mask) over a step of size h.

    watched: the watched site if it is seen at substeps (kernel.splitting.explicit.is_seen), else 0; best: its largest
    |v| so far in this part of the run.
    Returns the number of substeps, the largest |v|, its time within the step (-1: it was before), and where one of the
    quantities asks for it the largest push and its time within the step.
    """
    free = longest = h / rule.parts
    t, t_best, t_top, fine, pending, a_before, substeps = 0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0
    zero, keep0, keep1, first = splat(0.0), load(mask, 0), load(mask, WIDTH), load(mask, 2 * WIDTH)
    e0, e1, v0, v1, a0, a1 = load(e, 1), load(e, 1 + WIDTH), load(v, 1), load(v, 1 + WIDTH), zero, zero
    gap, at_kick, v_impactor = e[0], e[0], v[0]
    # The push at the start of the step: a 0 in its place would look like a crest where a push goes on. The next push is
    # half a substep later, which `crest_of_three` takes for a whole one: an error of second order in the substep.
    top = push_before = push_earlier = chain.contact.push(-gap)
    while t < h * (1.0 - ROUNDING):
        dt, fine = _substep(chain, -gap, v_impactor - element(v0, 0), rule, longest, fine)
        if not dt > SUBSTEP_MIN * h:
            v_impactor, v0 = math.nan, splat(math.nan)  # the run is lost, and its guards see it
            break
        touching, longest = gap < 0.0, free
        begun = e0, e1, v0, v1, a0, a1, pending, gap, at_kick, v_impactor, t, best, t_best, a_before
        pushes = top, t_top, push_earlier, push_before
        dt, count = _equal(dt, h - t, SUBSTEPS_PER_LOOK if touching else 1)
        h0, h1 = dt * keep0, dt * keep1
        for _ in range(count):
            x, before = t / h, _watched(v0, v1, watched)
            v_end = border.v + x * (border.p1 + x * (border.p2 + x * border.p3))
            drift_h = pending + 0.5 * dt
            at_kick += drift_h * (element(v0, 0) - v_impactor)
            push = chain.contact.push(-at_kick)
            if asks_for_push(quantities):  # known as it is compiled
                top, t_top = _higher(top, t_top, push_earlier, push_before, push, t, dt)
                push_earlier, push_before = push_before, push
            w0, w1 = right_neighbours(v0, v1) - v0, right_neighbours(v1, splat(v_end)) - v1
            e0, e1 = drift_h * w0 + e0, drift_h * w1 + e1
            r0 = 0.5 * dt * (right_neighbours(a0, a1) - a0) + w0
            r1 = 0.5 * dt * (right_neighbours(a1, zero) - a1) + w1
            g0, g1 = _tension(chain, e0, r0), _tension(chain, e1, r1)
            a0, a1 = push * first + (g0 - left_neighbours(zero, g0)), g1 - left_neighbours(g0, g1)
            v0, v1 = h0 * a0 + v0, h1 * a1 + v1
            a0, a1 = keep0 * a0, keep1 * a1
            v_impactor -= dt * push / chain.impactor_mass
            pending = 0.5 * dt
            gap = at_kick + pending * (element(v0, 0) - v_impactor)
            t += dt
            substeps += 1
            if watched > 0:
                now = _watched(v0, v1, watched)
                a_now = (now - before) / dt
                best, t_best = _fastest(best, t_best, before, now, a_before, a_now, t, dt)
                a_before = a_now
            if touching and gap >= 0.0:
                break
        if not touching and _is_found_too_late(chain, -gap, v_impactor - element(v0, 0), rule, dt, fine):
            e0, e1, v0, v1, a0, a1, pending, gap, at_kick, v_impactor, t, best, t_best, a_before = begun
            top, t_top, push_earlier, push_before = pushes
            longest = 0.5 * dt
    v_end = border.v + border.p1 + border.p2 + border.p3
    store(e, 1, pending * (right_neighbours(v0, v1) - v0) + e0)
    store(e, 1 + WIDTH, pending * (right_neighbours(v1, splat(v_end)) - v1) + e1)
    store(v, 1, v0)
    store(v, 1 + WIDTH, v1)
    e[0], v[0] = gap, v_impactor
    return substeps, best, t_best, top, t_top


@jit
def crest_of_three(a: float, b: float, c: float) -> float:
    """Highest point of the parabola through three equally spaced numbers, where the middle one is the largest."""
    return b + 0.125 * (a - c) * (a - c) / (2.0 * b - a - c) if b > a and b >= c else max(b, c)


@jit
def _higher(top: float, t_top: float, a: float, b: float, c: float, t: float, dt: float) -> tuple[float, float]:
    """The largest push and its time, after the substep from t to t + dt with push c; a, b: those of the two before."""
    crest = crest_of_three(a, b, c)
    if crest > top:
        return crest, t + 0.5 * dt if c >= crest else max(0.0, t - 0.5 * dt)
    return top, t_top


@jit
def _watched(v0: Pack, v1: Pack, site: int) -> float:
    """Velocity of a site of the zone; 0: of none."""
    if site == 0:
        return 0.0
    return element(v0, site - 1) if site <= WIDTH else element(v1, site - 1 - WIDTH)
