"""Strong damping: leapfrog with Crank-Nicolson dampers and an implicit, energy-consistent contact.

A step of size h: drift the strains over h/2, then
    (1 + h D/2) v_new = (1 - h D/2) v_old + h f(e) + h F e_1,    D v = 2 zeta S v,
then drift over h/2: one spring evaluation and one tridiagonal solve (kernel.splitting.lanes), no bound on h from the
dampers. The drifts of two steps are joined, and pass the chain with the springs and the first half of the solve in one
sweep. The contact force F enters through one column of the inverse, (1 + q S)^-1 e_1 (Sherman and Morrison), which
leaves one scalar equation for it (kernel.laws).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from kernel.film import due, is_asked_for, take, take_last_frames
from kernel.jit import jit, written_out
from kernel.lend import address_of, borrowed, give_back, number_at, whole_at
from kernel.maxima import cubic_crest
from kernel.model import Array, Chain, tension
from kernel.run import Run
from kernel.simd import (
    greatest,
    larger,
    least,
    load_sixteen,
    right_neighbours,
    smaller,
    splat_as,
    store,
)
from kernel.splitting.lanes import (
    LANES,
    Lanes,
    add_up,
    carry_right,
    factor,
    new_lanes,
    new_row,
    place,
    rows_of,
    substitute_left,
)
from kernel.splitting.rules import ImplicitRule, bounds, held_stiffness, impactor_energy, link_and_site_energy
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET
from kernel.watch import Watch, begin, look, look_at_end, part_of

END = 1.0 - 1e-12
FADING = 0.2  # rate at which a stiffness once seen is forgotten
STEPS_PER_LOOK = 2  # steps between two looks at the stiffness


class State(NamedTuple):
    """The chain in the layout of kernel.splitting.lanes."""

    e: Array  # strains
    v: Array  # velocities


IMPACTOR, OVERLAP, PENDING = range(3)  # of LaneView.rest


class LaneView(NamedTuple):
    """The chain as quantities see it (kernel.quantities.View)."""

    N: int
    e: Any  # where the strains are (kernel.lend), as of those below
    v: Any
    places: Any  # as of kernel.splitting.lanes.Lanes
    rest: Any  # (3,): velocity of the impactor, overlap, time over which the links have yet to drift

    def velocity(self, i: int) -> float:
        return number_at(self.v, whole_at(self.places, i)) if i > 0 else number_at(self.rest, IMPACTOR)

    def strain(self, i: int) -> float:
        here = whole_at(self.places, i)
        after = number_at(self.v, whole_at(self.places, i + 1)) if i < self.N else 0.0  # the wall
        return number_at(self.e, here) + number_at(self.rest, PENDING) * (after - number_at(self.v, here))

    def gap(self) -> float:
        return -number_at(self.rest, OVERLAP)

    def show(self, strains: Array, velocities: Array) -> None:
        for i in range(1, self.N + 1):
            strains[i - 1], velocities[i - 1] = self.strain(i), self.velocity(i)


@jit
def view_of(N: int, s: State, lanes: Lanes, rest: Array) -> LaneView:
    """Who looks must hold the arrays as long."""
    return LaneView(N, address_of(s.e), address_of(s.v), address_of(lanes.places), address_of(rest))


@jit
def new_state(N: int) -> State:
    """Everything at rest and unstrained."""
    return State(new_row(N), new_row(N))


@jit
def drift(e: Array, v: Array, rows: int, dt: float) -> None:
    """Drift the links over dt."""
    v0 = load_sixteen(v, LANES)
    store(v, (rows + 1) * LANES, right_neighbours(v0, splat_as(0.0, v0)))
    for k in range(LANES, (rows + 1) * LANES, LANES):
        w = load_sixteen(v, k + LANES)
        store(e, k, dt * (w - v0) + load_sixteen(e, k))
        v0 = w


@jit
def push_right(
    chain: Chain,
    e: Array,
    v: Array,
    carry: Array,
    weight: Array,
    from_left: Array,
    rows: int,
    reach: int,
    drift_h: float,
    h: float,
    q: float,
) -> None:
    """Drift the links over drift_h, let them push with h f(e) + q (velocity difference), and do the solve's first half.

    v becomes the forward recurrence of every lane by itself, from the velocities so pushed; `carry` what it lacks.
    """
    v0 = load_sixteen(v, LANES)
    zero = splat_as(0.0, v0)
    store(v, (rows + 1) * LANES, right_neighbours(v0, zero))
    impulse = y = zero
    for k in range(LANES, (rows + 1) * LANES, LANES):
        w, left = load_sixteen(v, k + LANES), impulse
        d = w - v0
        x = drift_h * d + load_sixteen(e, k)
        store(e, k, x)
        impulse = h * chain.spring.excess(x) + (h * x + q * d)
        y = load_sixteen(weight, k - LANES) * y + (v0 + (impulse - left))
        store(v, k, y)
        v0 = w
    carry_right(carry, weight, from_left, y, impulse, rows, reach)


@jit
def strains(chain: Chain, e: Array, rows: int) -> tuple[float, float]:
    """Smallest strain, 0 at most, and the largest, 0 at least, where the stiffness depends on it."""
    low = high = splat_as(0.0, load_sixteen(e, 0))
    for k in range(LANES, (rows + 1) * LANES, LANES):
        low = smaller(load_sixteen(e, k), low)
        if chain.spring.stiffens_in_tension():
            high = larger(load_sixteen(e, k), high)
    return least(low), greatest(high)


@jit
def time_to_event(overlap: float, closing: float) -> float:
    """Until the contact opens or closes at this rate; infinite where it does neither."""
    return -overlap / closing if overlap * closing < 0.0 else math.inf


@jit
def next_step(h: float, want: float, h_max: float, left: float) -> float:
    """h_max / 2^k, and changed only when it must or may double: a new step costs a factorisation."""
    if h == 0.0 or want < h or want >= 2.0 * h:
        h = h_max
        while h > want:
            h *= 0.5
    return min(h, left)


@jit
def acceleration(
    chain: Chain, e: Array, v: Array, left: int, here: int, right: int, drift_h: float, push: float
) -> float:
    """Acceleration of the site at `here` between neighbours (left = here: it is site 1) when its links have drifted
    over drift_h more; push: contact force."""
    z, dv, dv_left = 2.0 * chain.zeta, v[right] - v[here], v[here] - v[left]
    g = tension(chain.spring, e[here] + drift_h * dv) + z * dv
    g_left = tension(chain.spring, e[left] + drift_h * dv_left) + z * dv_left
    return g - (-push if left == here else g_left)


@written_out
def leap(
    chain: Chain, s: State, lanes: Lanes, reach: int, h: float, pending: float, v0: float, overlap: float
) -> tuple[float, float, float]:
    """One step of the velocities, with the factors of h; the links have yet to drift over `pending`, then over h/2.

    v0, overlap: of impactor and contact; returns both after the step, and the contact's mean push.
    """
    e, v = s
    rows, pivot, weight, from_left, from_right, column, carry, _ = lanes
    approach = v0 - v[LANES]
    push_right(chain, e, v, carry, weight, from_left, rows, reach, pending + 0.5 * h, h, h * chain.zeta)
    first = substitute_left(v, carry, pivot, weight, from_left, from_right, rows, reach)
    softness = 0.5 * h * h * (1.0 / chain.impactor_mass + column[LANES])
    overlap, push = chain.contact.impulse(overlap, overlap + 0.5 * h * (approach + v0 - first), softness)
    v0 -= h * push / chain.impactor_mass
    add_up(v, carry, from_right, column, h * push, rows, reach)
    return v0, overlap, push


@jit
def take_frames(
    film: Any,
    chain: Chain,
    s: State,
    lanes: Lanes,
    t: float,
    h: float,
    pending: float,
    v0: float,
    overlap: float,
    V: float,
) -> None:
    """Those within the step from t to t + h, which is not taken yet; lanes: for their own factors."""
    if film is not None and due(film, t + h):
        e, v = s.e.copy(), s.v.copy()
        while due(film, t + h):
            to, rest = film.times[film.taken[0]] - t, np.array([v0, overlap, pending])
            if to > 0.0:
                reach = factor(chain.N, lanes, to * chain.zeta)
                rest[IMPACTOR], rest[OVERLAP], _ = leap(chain, s, lanes, reach, to, pending, v0, overlap)
                rest[PENDING] = 0.5 * to
            take(chain, film, view_of(chain.N, s, lanes, rest), V)
            give_back(rest)
            for i in range(len(e)):
                s.e[i], s.v[i] = e[i], v[i]


@jit
def energy(chain: Chain, s: State, rows: int, v0: float, overlap: float) -> float:
    """Total energy; beyond the end of the chain everything is at rest and unstrained."""
    total = impactor_energy(chain, v0, overlap)
    for k in range(LANES, (rows + 1) * LANES):
        total += link_and_site_energy(chain, s.e[k], s.v[k])
    return total


@jit
def run_implicit(chain: Chain, V: float, rule: ImplicitRule, max_steps: int, watch: Watch) -> Run:
    """One impact at speed V to its end."""
    N, mid, rows, t_end = chain.N, chain.site, rows_of(chain.N), chain.t_end
    own, own_lanes, own_rest, limit = new_state(N), new_lanes(N), np.zeros(3), bounds(chain, V)
    s, lanes, rest = borrowed(own), borrowed(own_lanes), borrowed(own_rest)
    spare = new_lanes(N if is_asked_for(watch.film) else 1)
    left, here = place(max(1, mid - 1), rows), place(mid, rows)
    right = place(mid + 1, rows) if mid < N else 0  # the wall: what lies before the first row is zero
    e, v = s
    crests, quantities, memory, film = watch
    view = view_of(N, s, lanes, rest)
    begin(quantities, chain, V, memory)
    v0, overlap, reach = V, 0.0, 0  # of the impactor, of the contact, of a carry (kernel.splitting.lanes.factor)
    status, steps, stiff, cap, last_event = DONE, 0, 1.0, rule.h_max, -math.inf
    t, h, pending, best, t_best, a0 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    while t < t_end * END:
        if steps % STEPS_PER_LOOK == 0:
            lowest, highest = strains(chain, e, rows)
            stiff = held_stiffness(chain, lowest, highest, stiff, FADING * h)
            cap = min(rule.h_max, 0.5 * rule.theta / math.sqrt(stiff))
        if not (stiff < limit.stiffness and abs(v[here]) + abs(v[LANES]) < limit.speed):
            status = NOT_FINITE
            break
        if steps >= max_steps:
            status = STEP_BUDGET
            break
        near = rule.near_event * min(t - last_event, time_to_event(overlap, v0 - v[LANES]))
        new = next_step(h, min(max(rule.first, rule.growth * t), max(rule.shortest, near), cap), rule.h_max, t_end - t)
        if new != h:
            h = new
            reach = factor(N, lanes, h * chain.zeta)
        take_frames(film, chain, s, spare, t, h, pending, v0, overlap, V)
        before, was_open = v[here], overlap < 0.0
        v0, overlap, push = leap(chain, s, lanes, reach, h, pending, v0, overlap)
        pending = 0.5 * h
        a1 = acceleration(chain, e, v, left, here, right, pending, push)
        part = part_of(t, t_end)
        if a1 * a0 < 0.0 or abs(v[here]) > crests[part]:
            speed, where = cubic_crest(h, before, v[here], a0, a1)
            crests[part] = max(crests[part], speed)
            if speed > best:
                best, t_best = speed, t + where * h
        a0 = a1
        if len(quantities) > 0:  # known as it is compiled: of nothing nothing is left
            rest[IMPACTOR], rest[OVERLAP], rest[PENDING] = v0, overlap, pending
            look(quantities, chain, view, t, h, memory)
        t += h
        steps += 1
        if (overlap < 0.0) != was_open:
            last_event = t
    drift(e, v, rows, pending)
    rest[IMPACTOR], rest[OVERLAP], rest[PENDING] = v0, overlap, 0.0
    look_at_end(quantities, chain, view, t, memory)
    if status == DONE:
        take_last_frames(film, chain, view, V)
    remaining = energy(chain, s, rows, v0, overlap)
    give_back(own)
    give_back(own_lanes)
    give_back(own_rest)
    if status == DONE and not remaining <= limit.energy:
        status = NOT_FINITE
    return Run(status, best, t_best, steps, steps, N * steps, remaining, 0)
