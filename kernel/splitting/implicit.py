"""Strong damping: leapfrog with Crank-Nicolson dampers and an implicit, energy-consistent contact, step by step.

What a step does stands in kernel.splitting.damped.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from kernel.arrival import SURE_BELOW
from kernel.film import due, take, take_last_frames
from kernel.jit import jit
from kernel.lend import borrowed, give_back
from kernel.maxima import cubic_crest
from kernel.model import Array, Chain
from kernel.run import Run
from kernel.splitting.damped import (
    IMPACTOR,
    OVERLAP,
    PENDING,
    State,
    acceleration,
    drift,
    energy,
    leap,
    let_in,
    new_state,
    strains,
    view_of,
)
from kernel.splitting.lanes import LANES, Lanes, factor, new_lanes, number, reach_of, rows_of
from kernel.splitting.rules import IMPLICIT_FADE, Bounds, ImplicitRule, bounds, held_stiffness
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET
from kernel.watch import Watch, begin, look, look_at_end, part_of

END = 1.0 - 1e-12
STEPS_PER_LOOK = 2  # steps between two looks at the stiffness
FIRST_SITES = 64  # active at the start; kernel.splitting.damped.let_in lets in more
REACHED = 1e-11  # of the impact speed: of a site from which on a step can reach the last one


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
def take_frames(
    film: Any,
    chain: Chain,
    s: State,
    lanes: Lanes,
    n: int,
    t: float,
    h: float,
    pending: float,
    v0: float,
    overlap: float,
) -> None:
    """Take the frames of the film within the coming step of n sites, from t to t + h; lanes: room for factors."""
    if film is not None and due(film, t + h):
        e, v = s.e.copy(), s.v.copy()
        while due(film, t + h):
            to, rest = film.times[film.taken[0]] - t, np.array([v0, overlap, pending])
            if to > 0.0:
                reach = factor(n, lanes, to * chain.zeta)
                rest[IMPACTOR], rest[OVERLAP], _ = leap(chain, s, lanes, rows_of(n), reach, to, pending, v0, overlap)
                rest[PENDING] = 0.5 * to
            take(chain, film, view_of(chain.N, s, lanes, rest))
            give_back(rest)
            for i in range(len(e)):
                s.e[i], s.v[i] = e[i], v[i]


class Motion(NamedTuple):
    """Where a run is, beside the chain, and what it has seen."""

    t: float
    h: float  # last step
    pending: float  # time over which the links have yet to drift
    v0: float  # velocity of the impactor
    indentation: float  # the contact's overlap
    a0: float  # acceleration of the watched site
    stiff: float  # largest f' of late
    cap: float  # what that allows as a step
    last_event: float  # when the contact last opened or closed
    best: float  # largest speed of the watched site
    t_best: float
    n: int  # sites that are integrated
    steps: int
    sites: int  # summed over the steps
    status: int


@jit
def anew(m: Motion) -> Motion:
    """The run at the same place, as if it had taken no step: the next step need not be half or twice the last one."""
    t, _, pending, v0, overlap, a0, stiff, cap, last_event, best, t_best, n, steps, sites, status = m
    return Motion(t, 0.0, pending, v0, overlap, a0, stiff, cap, last_event, best, t_best, n, steps, sites, status)


@jit
def march(
    chain: Chain,
    V: float,
    s: State,
    lanes: Lanes,
    spare: Lanes,
    rest: Array,
    m: Motion,
    rule: ImplicitRule,
    until: float,
    sure: float,
    max_steps: int,
    limit: Bounds,
    watch: Watch,
) -> Motion:
    """Integrate until then, or until the watched site is faster than `sure`."""
    N, mid, t_end = chain.N, chain.site, chain.t_end
    t, h, pending, v0, overlap, a0, stiff, cap, last_event, best, t_best, n, steps, sites, status = m
    s, lanes, rest = borrowed(s), borrowed(lanes), borrowed(rest)
    rows, reach, factored, edge, left, here, right, speed = rows_of(n), 0, 0.0, 0, 0, lanes.places[mid], 0, 0.0
    e, v = s
    crests, quantities, memory, film = watch
    view = view_of(N, s, lanes, rest)
    while t < until * END:
        if steps % STEPS_PER_LOOK == 0:
            lowest, highest = strains(chain, e, rows)
            stiff = max(limit.least, held_stiffness(chain, lowest, highest, stiff, IMPLICIT_FADE * h))
            cap = 0.5 / math.sqrt(stiff)
        if not (stiff < limit.stiffness and abs(v[here]) + abs(v[LANES]) < limit.speed):
            status = NOT_FINITE
            break
        if steps >= max_steps:
            status = STEP_BUDGET
            break
        near = max(rule.shortest, rule.near_event * min(t - last_event, time_to_event(overlap, v0 - v[LANES])))
        want = min(max(rule.first, rule.growth * t), near, rule.h_max, rule.theta * cap)
        h = next_step(h, want, rule.h_max, t_end - t)
        if h != factored or (n < N and abs(v[edge]) > REACHED * V):
            factored, spread = h, reach_of(h * chain.zeta)
            n = let_in(s, lanes, n, N, spread, REACHED * V)
            rows, reach = rows_of(n), factor(n, lanes, h * chain.zeta)
            edge, left, here = lanes.places[max(1, n - spread)], lanes.places[max(1, mid - 1)], lanes.places[mid]
            right = lanes.places[mid + 1] if mid < N else 0  # the wall
            if film is not None:
                number(spare, n)
        take_frames(film, chain, s, spare, n, t, h, pending, v0, overlap)
        before, was_open = v[here], overlap < 0.0
        v0, overlap, push = leap(chain, s, lanes, rows, reach, h, pending, v0, overlap)
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
        steps += 1
        sites += n
        if speed > sure:
            break
        t += h
        if (overlap < 0.0) != was_open:
            last_event = t
    return Motion(t, h, pending, v0, overlap, a0, stiff, cap, last_event, best, t_best, n, steps, sites, status)


@jit
def run_implicit(chain: Chain, V: float, rule: ImplicitRule, later: ImplicitRule, max_steps: int, watch: Watch) -> Run:
    """One impact at speed V to its end.

    rule, later: steps until sound has crossed the chain, and coarser ones from then on, which tell whether the first
    arrival wins by far; where it does not, the rest is done again with those of `rule` (kernel.arrival).
    """
    N, t_end, limit, lost, lost_sites = chain.N, chain.t_end, bounds(chain, V), 0, 0
    hasty = later.theta > rule.theta and limit.least == 0.0
    s, lanes, rest, spare = new_state(N), new_lanes(N), np.zeros(3), new_lanes(1 if watch.film is None else N)
    crests, quantities, memory, film = watch
    view = view_of(N, s, lanes, rest)
    begin(quantities, chain, V, memory)
    m = Motion(0.0, 0.0, 0.0, V, 0.0, 0.0, 1.0, 1.0, -math.inf, 0.0, 0.0, min(N, FIRST_SITES), 0, 0, DONE)
    number(lanes, m.n)
    m = march(chain, V, s, lanes, spare, rest, m, rule, N if hasty else t_end, math.inf, max_steps, limit, watch)
    if hasty and m.status == DONE:
        crossed, e, v, seen = m, s.e.copy(), s.v.copy(), crests.copy()
        sure = m.best * math.sqrt(SURE_BELOW)
        m = march(chain, V, s, lanes, spare, rest, anew(m), later, t_end, sure, max_steps, limit, watch)
        if m.status == NOT_FINITE or (m.status == DONE and m.t < t_end * END):
            lost, lost_sites = m.steps - crossed.steps, m.sites - crossed.sites
            s.e[:], s.v[:], crests[:] = e, v, seen
            number(lanes, crossed.n)
            m = march(chain, V, s, lanes, spare, rest, crossed, rule, t_end, math.inf, max_steps - lost, limit, watch)
    drift(s.e, s.v, rows_of(m.n), m.pending)
    rest[IMPACTOR], rest[OVERLAP], rest[PENDING] = m.v0, m.indentation, 0.0
    look_at_end(quantities, chain, view, m.t, memory)
    if m.status == DONE:
        take_last_frames(film, chain, view)
    remaining = energy(chain, s, rows_of(m.n), m.v0, m.indentation)
    give_back(s)
    give_back(lanes)
    give_back(rest)
    status = m.status
    if status == DONE and not remaining <= limit.energy:
        status = NOT_FINITE
    steps = m.steps + lost
    return Run(status, m.best, m.t_best, steps, steps, m.sites + lost_sites, remaining, 0)
