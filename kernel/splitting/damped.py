"""A strongly damped chain in 16 lanes (kernel.splitting.lanes): its state, how quantities see it, and one step of it.

A step of size h: drift the strains over h/2, then
    (1 + h D/2) v_new = (1 - h D/2) v_old + h f(e) + h F e_1,    D v = 2 zeta S v,
then drift over h/2: one spring evaluation and one tridiagonal solve, no bound on h from the dampers. The drifts of two
steps are joined, and pass the chain with the springs and the first half of the solve in one sweep. The contact force F
enters through one column of the inverse, (1 + q S)^-1 e_1 (Sherman and Morrison), which leaves one scalar equation for
it (kernel.laws).
"""

from typing import Any, NamedTuple

from kernel.jit import jit, written_out
from kernel.lend import address_of, number_at, whole_at
from kernel.model import Array, Chain, tension
from kernel.simd import greatest, larger, least, load_sixteen, right_neighbours, smaller, splat_as, store
from kernel.splitting.lanes import (
    LANES,
    Lanes,
    add_up,
    carry_right,
    lay_out,
    new_row,
    number,
    rows_of,
    substitute_left,
)
from kernel.splitting.rules import impactor_energy, link_and_site_energy


class State(NamedTuple):
    """The chain in the layout of kernel.splitting.lanes."""

    e: Array  # strains
    v: Array  # velocities


QUARTER = 4  # one part of so many, as many sites more, are let in at once: each time costs a factorisation
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
def acceleration(
    chain: Chain, e: Array, v: Array, left: int, here: int, right: int, drift_h: float, push: float
) -> float:
    """Acceleration of the site at `here` between its neighbours, of which the first has but one, when its links have
    drifted over drift_h more; push: contact force."""
    z, dv, dv_left = 2.0 * chain.zeta, v[right] - v[here], v[here] - v[left]
    g = tension(chain.spring, e[here] + drift_h * dv) + z * dv
    g_left = tension(chain.spring, e[left] + drift_h * dv_left) + z * dv_left
    return g - (-push if here == LANES else g_left)


@written_out
def leap(
    chain: Chain, s: State, lanes: Lanes, rows: int, reach: int, h: float, pending: float, v0: float, overlap: float
) -> tuple[float, float, float]:
    """One step of the velocities, with the factors of h; the links have yet to drift over `pending`, then over h/2.

    v0, overlap: of impactor and contact; returns both after the step, and the contact's mean push.
    """
    e, v = s
    pivot, weight, from_left, from_right, column, carry, _ = lanes
    approach = v0 - v[LANES]
    push_right(chain, e, v, carry, weight, from_left, rows, reach, pending + 0.5 * h, h, h * chain.zeta)
    first = substitute_left(v, carry, pivot, weight, from_left, from_right, rows, reach)
    softness = 0.5 * h * h * (1.0 / chain.impactor_mass + column[LANES])
    overlap, push = chain.contact.impulse(overlap, overlap + 0.5 * h * (approach + v0 - first), softness)
    v0 -= h * push / chain.impactor_mass
    add_up(v, carry, from_right, column, h * push, rows, reach)
    return v0, overlap, push


@jit
def let_in(s: State, lanes: Lanes, n: int, N: int, reach: int, reached: float) -> int:
    """How many sites to integrate, n until now, so that a step does not reach the last of them from what moves.

    Lays out the chain, and the room for factors, for them; reach: of a step, in sites (lanes.reach_of).
    """
    more = n
    while more < N and (more <= reach or (more <= n + reach and abs(s.v[lanes.places[more - reach]]) > reached)):
        more = min(N, more + max(LANES, more // QUARTER))
    if more > n:
        lay_out(s.e, n, rows_of(n), rows_of(more))
        lay_out(s.v, n, rows_of(n), rows_of(more))
        number(lanes, more)
    return more


@jit
def energy(chain: Chain, s: State, rows: int, v0: float, overlap: float) -> float:
    """Total energy; beyond the end of the chain everything is at rest and unstrained."""
    total = impactor_energy(chain, v0, overlap)
    for k in range(LANES, (rows + 1) * LANES):
        total += link_and_site_energy(chain, s.e[k], s.v[k])
    return total
