"""Light damping: a fourth-order splitting over the whole chain, the contact resolved at the struck end.

The step is taken without contact, its size from the stiffest link. If the gap closes anywhere in it, the struck end is
taken back to the step's start and integrated with substeps (kernel.splitting.zone).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from kernel.arrival import SURE_BELOW, SURE_BELOW_IF_CHAOTIC
from kernel.film import due, take, take_last_frames
from kernel.jit import jit, written_out
from kernel.lend import address_of, borrowed, give_back, number_at
from kernel.maxima import quintic_crest
from kernel.model import Array, Chain, disturb
from kernel.run import Run
from kernel.simd import WIDEST, WIDTH
from kernel.splitting.coefficients import DRIFTS, KICKS, MIDDLE_KICKS, SECOND, STAGES, THIRD
from kernel.splitting.rules import (
    Bounds,
    ExplicitRule,
    bounds,
    held_stiffness,
    impactor_energy,
    link_and_site_energy,
    shock_stiffness,
)
from kernel.splitting.sweeps import (
    accelerate,
    acceleration_and_jerk,
    drift,
    end_mask,
    kick,
    row,
    spread,
    strains,
)
from kernel.splitting.zone import (
    SITES_KEPT,
    ZONE_SITES,
    Zone,
    beyond,
    border_between,
    copy_from,
    copy_to,
    new_zone,
    resolve,
    touches,
)
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET
from kernel.watch import Watch, begin, look, look_at_end, part_of, take_push

_DRIFTS, _KICKS = np.array(DRIFTS), np.array(KICKS)
FIRST_SITES, MORE_SITES = 32, 16  # active at the start, and let in when the wave comes near the last; whole packs
REACHED = 1e-11  # of the impact speed: sum of the last WIDTH speeds from which on more sites are let in
END = 1.0 - 1e-12


class State(NamedTuple):
    """The chain in the layout of kernel.splitting.sweeps."""

    e: Array
    v: Array
    a: Array  # accelerations, for the corrections of the dampers
    whole: Array  # (16,) ones: mask of the last pack of a sweep that ends within the chain
    end: Array  # (16,) mask of the chain's last pack


class RowView(NamedTuple):
    """The chain as quantities see it (kernel.quantities.View); e, v: where they are (kernel.lend)."""

    e: Any
    v: Any

    def velocity(self, i: int) -> float:
        return number_at(self.v, i)

    def strain(self, i: int) -> float:
        return number_at(self.e, i)

    def gap(self) -> float:
        return number_at(self.e, 0)

    def tells_push(self) -> None:
        """By `kernel.splitting.zone.resolve`."""

    def show(self, strains: Array, velocities: Array) -> None:
        for i in range(len(strains)):
            strains[i], velocities[i] = number_at(self.e, i + 1), number_at(self.v, i + 1)


@jit
def new_state(N: int, V: float, one: Any) -> State:
    """Everything at rest and unstrained but the impactor; as precise as `one`."""
    s = State(row(N, one), row(N, one), row(N, one), np.full(WIDEST, one), end_mask(N, one))
    s.v[0] = V
    return s


@jit
def step(chain: Chain, s: State, n: int, h: float) -> None:
    """One step of the first n sites without contact."""
    e, v = s.e, s.v
    mask = s.end if n == chain.N else s.whole
    x = 2.0 * chain.zeta * h
    for stage in range(STAGES):
        drift_h, kick_h = _DRIFTS[stage] * h, _KICKS[stage] * h
        e[0] += drift_h * (v[1] - v[0])
        if chain.zeta > 0.0 and MIDDLE_KICKS[0] <= stage <= MIDDLE_KICKS[1]:
            accelerate(chain, e, v, s.a, n, drift_h, mask)
            spread(v, s.a, n, kick_h, SECOND * h * x, THIRD * h * x * x, mask)
        else:
            kick(chain, e, v, n, drift_h, kick_h, mask)
    drift_h = _DRIFTS[STAGES] * h
    e[0] += drift_h * (v[1] - v[0])
    drift(e, v, n, drift_h)


@jit
def is_seen(chain: Chain) -> bool:
    """Whether the watched site is seen at every substep of the contact: the zone is the whole chain, or it is near."""
    return chain.site <= SITES_KEPT or chain.N <= ZONE_SITES


@written_out
def step_with_contact(
    chain: Chain, s: State, zone: Zone, rule: ExplicitRule, n: int, h: float, best: float, quantities: Any
) -> tuple[bool, int, float, float, float, float]:
    """One step of the first n sites; best: the middle site's largest |v| so far in this part of the run.

    Returns whether impactor and chain touched in it, and if so what `kernel.splitting.zone.resolve` tells.
    """
    e, v, m = s.e, s.v, zone.m
    closed = m == chain.N
    copy_from(zone.e, zone.v, e, v)
    gap0, rate0 = np.float64(e[0]), np.float64(v[1] - v[0])
    va0, aa0 = (0.0, 0.0) if closed else beyond(chain, e, v, m)
    step(chain, s, n, h)
    if not touches(gap0, np.float64(e[0]), rate0, np.float64(v[1] - v[0]), h):
        return False, 0, 0.0, -1.0, 0.0, 0.0
    va1, aa1 = (0.0, 0.0) if closed else beyond(chain, e, v, m)
    border = border_between(h, va0, va1, aa0, aa1)
    watched = chain.site if is_seen(chain) else 0
    told = resolve(chain, zone.e, zone.v, zone.mask, rule, border, h, watched, best, quantities)
    copy_to(zone, closed, e, v)
    return True, *told


@jit
def take_frames(
    film: Any,
    chain: Chain,
    s: State,
    zone: Zone,
    rule: ExplicitRule,
    n: int,
    t: float,
    h: float,
    quantities: Any,
) -> None:
    """Take the frames of the film that lie within the coming step, from t to t + h."""
    if film is not None and due(film, t + h):
        e, v = s.e.copy(), s.v.copy()
        while due(film, t + h):
            to = film.times[film.taken[0]] - t
            if to > 0.0:
                step_with_contact(chain, s, zone, rule, n, to, math.inf, quantities)
            take(chain, film, RowView(address_of(s.e), address_of(s.v)))
            for i in range(len(e)):
                s.e[i], s.v[i] = e[i], v[i]


@jit
def energy(chain: Chain, s: State) -> float:
    """Total energy."""
    total = impactor_energy(chain, np.float64(s.v[0]), -np.float64(s.e[0]))
    for i in range(1, chain.N + 1):
        total += link_and_site_energy(chain, np.float64(s.e[i]), np.float64(s.v[i]))
    return total


@jit
def more_sites(v: Array, n: int, N: int, reached: float) -> int:
    """How many sites the next step integrates."""
    if n >= N:
        return N
    far = 0.0
    for i in range(n - WIDTH + 1, n + 1):
        far += abs(np.float64(v[i]))
    return min(N, n + MORE_SITES) if far > reached else n


class Motion(NamedTuple):
    """Where a run is, beside the chain, and what it has seen."""

    t: float
    h: float  # last step
    stiff: float  # largest f' of late
    a0: float  # acceleration of the watched site, and its derivative
    jerk0: float
    best: float  # largest speed of the watched site
    t_best: float
    n: int  # sites that are integrated
    steps: int
    substeps: int
    sites: int  # summed over the steps
    status: int


@jit
def march(
    chain: Chain,
    V: float,
    s: State,
    zone: Zone,
    m: Motion,
    rule: ExplicitRule,
    until: float,
    sure: float,
    max_steps: int,
    limit: Bounds,
    watch: Watch,
) -> Motion:
    """Integrate until then, or until the watched site is faster than `sure`."""
    N, mid, t_end, near = chain.N, chain.site, chain.t_end, is_seen(chain)
    t, h, stiff, a0, jerk0, best, t_best, n, steps, substeps, sites, status = m
    s, zone, fastest = borrowed(s), borrowed(zone), 0.0
    e, v = s.e, s.v
    crests, quantities, memory, film = watch
    view = RowView(address_of(e), address_of(v))
    while t < until * END:
        lowest, highest = strains(chain, e, n)
        stiff = max(limit.least, held_stiffness(chain, lowest, highest, stiff, rule.fade * h))
        if not (stiff < limit.stiffness and abs(v[mid]) + abs(v[1]) < limit.speed):
            status = NOT_FINITE
            break
        if steps + substeps >= max_steps:
            status = STEP_BUDGET
            break
        h = min(rule.h_max, 0.5 * rule.theta / math.sqrt(stiff), t_end - t)
        part = part_of(t, t_end)
        take_frames(film, chain, s, zone, rule, n, t, h, quantities)
        v0 = np.float64(v[mid])
        touched, more, speed, within, push, pushed = step_with_contact(
            chain, s, zone, rule, n, h, crests[part], quantities
        )
        if touched:
            take_push(quantities, push, t + pushed, memory)
            substeps += more
            if within >= 0.0:
                crests[part] = fastest = speed
                if speed > best:
                    best, t_best = speed, t + within
        a1, jerk1 = acceleration_and_jerk(chain, e, v, mid)
        v1 = np.float64(v[mid])
        if not (touched and near) and max(abs(v0) + h * abs(a0), abs(v1) + h * abs(a1)) > crests[part]:
            speed, where = quintic_crest(h, v0, v1, a0, a1, jerk0, jerk1)
            crests[part] = max(crests[part], speed)
            fastest = speed
            if speed > best:
                best, t_best = speed, t + where * h
        a0, jerk0 = a1, jerk1
        if len(quantities) > 0:  # known as it is compiled: of nothing nothing is left
            look(quantities, chain, view, t, h, memory)
        steps += 1
        sites += n
        if fastest > sure:
            break
        t += h
        n = more_sites(v, n, N, REACHED * V)
    return Motion(t, h, stiff, a0, jerk0, best, t_best, n, steps, substeps, sites, status)


@jit
def run_explicit(
    chain: Chain,
    V: float,
    rule: ExplicitRule,
    later: ExplicitRule,
    max_steps: int,
    noise: float,
    watch: Watch,
    one: Any,
) -> Run:
    """One impact at speed V to its end.

    rule, later: steps until sound has crossed the chain, and coarser ones from then on, which tell whether the first
    arrival wins by far; where it does not, the rest is done again with those of `rule` (kernel.arrival); noise: size of
    random first velocities of the sites, over V, with which also those that the wave has not reached are integrated;
    one: of the precision in which the chain is kept (kernel.simd).
    """
    N, t_end = chain.N, chain.t_end
    s, zone, limit = new_state(N, V, one), new_zone(N), bounds(chain, V)
    hasty = later.theta > rule.theta and limit.least == 0.0
    crests, quantities, memory, film = watch
    view = RowView(address_of(s.e), address_of(s.v))
    begin(quantities, chain, V, memory)
    if noise != 0.0:
        disturb(s.v[1:], N, noise * V)
    n = N if noise != 0.0 else min(N, FIRST_SITES)
    stiff = min(shock_stiffness(chain, V), 0.5 * limit.stiffness)
    m = Motion(0.0, 0.0, stiff, 0.0, 0.0, 0.0, 0.0, n, 0, 0, 0, DONE)
    m = march(chain, V, s, zone, m, rule, N if hasty else t_end, math.inf, max_steps, limit, watch)
    lost_steps, lost_substeps, lost_sites = 0, 0, 0
    if hasty and m.status == DONE:
        crossed, e, v, seen = m, s.e.copy(), s.v.copy(), crests.copy()
        sure = m.best * math.sqrt(SURE_BELOW if chain.spring.is_linear() else SURE_BELOW_IF_CHAOTIC)
        m = march(chain, V, s, zone, m, later, t_end, sure, max_steps, limit, watch)
        if m.status == NOT_FINITE or (m.status == DONE and (m.t < t_end * END or energy(chain, s) > limit.energy)):
            lost_steps, lost_substeps = m.steps - crossed.steps, m.substeps - crossed.substeps
            lost_sites, left = m.sites - crossed.sites, max_steps - lost_steps - lost_substeps
            s.e[:], s.v[:], crests[:] = e, v, seen
            m = march(chain, V, s, zone, crossed, rule, t_end, math.inf, left, limit, watch)
    look_at_end(quantities, chain, view, m.t, memory)
    if m.status == DONE:
        take_last_frames(film, chain, view)
    run = finish(chain, s, limit, m, lost_steps, lost_substeps, lost_sites)
    give_back(s)
    give_back(zone)
    return run


@jit
def finish(
    chain: Chain, s: State, limit: Bounds, m: Motion, lost_steps: int, lost_substeps: int, lost_sites: int
) -> Run:
    """Close the books: a run that has gained energy is no run."""
    left, status = energy(chain, s), m.status
    if status == DONE and not left <= limit.energy:
        status = NOT_FINITE
    steps, substeps = m.steps + lost_steps, m.substeps + lost_substeps
    near = substeps * min(chain.N, ZONE_SITES)
    evaluations, sites = STAGES * steps + (near + chain.N - 1) // chain.N, STAGES * (m.sites + lost_sites) + near
    return Run(status, m.best, m.t_best, steps + substeps, evaluations, sites, left, 0)
