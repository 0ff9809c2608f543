"""Dormand-Prince 5(4) with ode45's step control: the paper's integrator and the reference method.

The arithmetic of one step is `kernel.stages.step`; here the steps are chosen and the books are kept. A run can be
advanced piece by piece, and the last step's continuous extension tells the state at any time within it: what is
observed never changes the steps.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel import tableau
from kernel.film import Film, due
from kernel.jit import jit
from kernel.lend import address_of, number_at, whole_at
from kernel.maxima import peak_of_quartic
from kernel.model import Array, Chain, dissipated_power, disturb, energy
from kernel.run import Run
from kernel.simd import WIDTH, load, splat, store
from kernel.stages import begin_piece, step
from kernel.state import LAST, State, new_state, padded, row
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET, STEP_TOO_SMALL
from kernel.subnormals import flush_subnormals, restore_subnormals
from kernel.varied import as_pushed, hold, longest_step
from kernel.watch import Watch, begin, largest_of, look, look_at_end, part_of

A, INTERPOLANT, STAGES = tableau.A, tableau.INTERPOLANT, tableau.STAGES
POWERS = np.hstack([INTERPOLANT, np.zeros((STAGES, WIDTH - 4))]).ravel()  # one pack per stage
POWER = 1.0 / tableau.ORDER  # of what is allowed over the error: how much longer a step would just keep it
REACHED = 1e-16  # of the impact speed: a slower site counts as not yet reached by the wave
FIRST_SITES, MORE_SITES = 16, 16  # integrated at the start, and let in when the wave comes near the last; whole packs
SMALLEST_STEP = 1e-30  # at t = 0, where ode45's bound is a subnormal
# ode45's step control. The next step is SAFETY times that with which the error would be what is allowed, at most
# GROWTH_MAX times the last one, after a step that failed no longer than it; a step that fails is made shorter, to
# SHRINK_MIN of itself at the least, to SHRINK_AGAIN where the one before failed as well.
SAFETY, GROWTH_MAX, SHRINK_MIN, SHRINK_AGAIN = 0.8, 5.0, 0.1, 0.5
LONGEST_OF_RUN = 0.1  # of the run: no step is longer
LAST_STRETCH = 1.0001  # times a step: where the end of the run is no farther the step goes there
SPACINGS_MIN = 16.0  # of floats at a time t: a shorter step from t would be rounding
# Three-point Gauss quadrature on [0, 1], for the energy that the dampers take in one step.
NODES = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))
NODE_WEIGHTS = (5 / 18, 8 / 18, 5 / 18)


class Settings(NamedTuple):
    """How to integrate."""

    rtol: float
    atol: float
    max_steps: int  # tried steps
    t_end: float
    reached: float  # speed below which the sites ahead of the wave are left alone; 0 integrates all from the start
    watch_energy: bool  # integrate the dissipation alongside


class March(NamedTuple):
    """One run under way. After `advance`, [t_from, t] is the last step."""

    s: State
    clock: Array  # (5,): t_from, t, next step, peak speed of the middle site, its time
    watch: Watch
    dissipated: Array  # (2,): energy that the dampers took until t_from, and until t
    tally: NDArray[np.int64]  # (6,): status, accepted steps, tried steps, site evaluations, active sites, half now


class EndView(NamedTuple):
    """The chain at the end of the last step as quantities see it (kernel.quantities.View)."""

    size: int  # of a half
    u: Any  # where they are (kernel.lend); these three as those of kernel.state.State
    v: Any
    impactor: Any
    tally: Any

    def velocity(self, i: int) -> float:
        then = 1 - whole_at(self.tally, NOW)
        return number_at(self.v, then * self.size + i - 1) if i > 0 else number_at(self.impactor, 2 * then + 1)

    def strain(self, i: int) -> float:
        here = (1 - whole_at(self.tally, NOW)) * self.size + i - 1
        return (number_at(self.u, here + 1) if i < self.size else 0.0) - number_at(self.u, here)

    def gap(self) -> float:
        then = 1 - whole_at(self.tally, NOW)
        return number_at(self.u, then * self.size) - number_at(self.impactor, 2 * then)


T_FROM, T_TO, NEXT_STEP, PEAK, T_PEAK = range(5)
STATUS, STEPS, TRIED, SITE_EVALUATIONS, ACTIVE, NOW = range(6)


@jit
def start(chain: Chain, speed: float, settings: Settings, watch: Watch) -> March:
    """At rest and unstrained but the impactor: nothing touches yet, so every acceleration is zero."""
    run = March(new_state(chain.N, speed), np.zeros(5), watch, np.zeros(2), np.zeros(6, np.int64))
    # ode45's first step: only u_0 moves at first, and it moves at the impact speed.
    first = SAFETY * settings.rtol**POWER * settings.atol / settings.rtol / speed
    run.clock[NEXT_STEP] = min(LONGEST_OF_RUN * settings.t_end, first)
    run.tally[ACTIVE] = min(padded(chain.N), FIRST_SITES) if settings.reached > 0.0 else padded(chain.N)
    begin(watch.quantities, chain, speed, watch.memory)
    return run


@jit
def look_at_start(chain: Chain, run: March) -> None:
    """Show the first state to the quantities of a chain that is neither at rest nor unstrained there."""
    run.tally[NOW] = 1  # a view shows the other half, as that holds the end of a step
    look(run.watch.quantities, chain, end_view(chain, run.s, run.tally), 0.0, 0.0, run.watch.memory)
    run.tally[NOW] = 0


@jit
def end_view(chain: Chain, s: State, tally: NDArray[np.int64]) -> EndView:
    """Who looks must hold the arrays as long."""
    return EndView(padded(chain.N), address_of(s.u), address_of(s.v), address_of(s.impactor), address_of(tally))


@jit
def found(chain: Chain, speed: float, run: March) -> Array:
    """(quantities,): what the run has told so far of each, at the end of the last step."""
    view = end_view(chain, run.s, run.tally)
    look_at_end(run.watch.quantities, chain, view, run.clock[T_TO], run.watch.memory)
    return largest_of(run.watch, chain, speed)


@jit
def advance(chain: Chain, run: March, settings: Settings, t_stop: float) -> None:
    """Step until the last step ends at or after t_stop (t_end at most), or until the status is not DONE."""
    s, clock, tally, p = run.s, run.clock, run.tally, np.zeros(1 + WIDTH)
    crests, quantities, memory, _ = run.watch
    view = end_view(chain, s, tally)
    middle, t_end, h_max = chain.site, settings.t_end, LONGEST_OF_RUN * settings.t_end
    threshold = settings.atol / settings.rtol
    word = flush_subnormals()
    failed = False
    while clock[T_TO] < min(t_stop, t_end) and tally[STATUS] == DONE:
        if clock[T_TO] > clock[T_FROM]:
            _accept(chain, run, settings.reached)
        t, wanted, n = clock[T_FROM], clock[NEXT_STEP], tally[ACTIVE]
        least = max(SPACINGS_MIN * np.spacing(t), SMALLEST_STEP)
        h = min(wanted, longest_step(chain.varied, t, least))
        is_cut = h < wanted
        last = t + LAST_STRETCH * h >= t_end
        h = t_end - t if last else h
        now = tally[NOW]
        begin_piece(chain.varied, s, now, t, h)
        error = step(chain.varied, chain, s, n, t, h, now, threshold)
        tally[TRIED] += 1
        tally[SITE_EVALUATIONS] += LAST * min(n, chain.N)
        if error <= settings.rtol:
            clock[T_TO] = t_end if last else t + h
            tally[STEPS] += 1
            velocity_quartic(p, s, now, h, middle)
            part = part_of(t, t_end)
            crests[part], at = peak_of_quartic(p, crests[part])
            if crests[part] > clock[PEAK]:
                clock[PEAK], clock[T_PEAK] = crests[part], t + at * h
            if len(quantities) > 0:  # known as it is compiled: of nothing nothing is left
                look(quantities, chain, view, t, h, memory)
            if settings.watch_energy:
                run.dissipated[0] = run.dissipated[1]
                run.dissipated[1] += dissipated_within(chain, s, now, h, 1.0)
            growth = SAFETY * (settings.rtol / error) ** POWER if error > 0.0 else GROWTH_MAX
            clock[NEXT_STEP] = min(h_max, h * (1.0 if failed else min(GROWTH_MAX, growth)))
            if is_cut:  # not because of its error
                clock[NEXT_STEP] = max(clock[NEXT_STEP], wanted)
            failed = False
        else:
            shrink = SAFETY * (settings.rtol / error) ** POWER if math.isfinite(error) else SHRINK_MIN
            clock[NEXT_STEP] = h * (SHRINK_AGAIN if failed else max(SHRINK_MIN, shrink))
            failed = True
        # Accepted steps, too, can become ever shorter: the speeds of a chain that breaks are infinite at a finite time.
        if clock[NEXT_STEP] < least and clock[T_TO] < t_end:
            tally[STATUS] = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        if tally[TRIED] >= settings.max_steps and clock[T_TO] < t_end:
            tally[STATUS] = STEP_BUDGET
    restore_subnormals(word)


@jit
def take_frames(chain: Chain, run: March, settings: Settings, film: Film) -> None:
    """Advance to all times of a film, which lie ahead; what the dampers take is integrated where settings say so."""
    while due(film, math.inf):
        k = film.taken[0]
        advance(chain, run, settings, film.times[k])
        if run.tally[STATUS] != DONE:
            break
        now, t_from = run.tally[NOW], run.clock[T_FROM]
        h = run.clock[T_TO] - t_from
        theta = (film.times[k] - t_from) / h if h > 0.0 else 0.0
        u, v = film.u[k % len(film.u)], film.v[k]
        u0, v0 = state_within(run.s, now, h, theta, u, v)
        film.impactor[k, 0], film.impactor[k, 1] = as_pushed(chain.varied, film.times[k], u0, v0)
        hold(chain.varied, film.times[k], u, v)
        if settings.watch_energy:
            film.dissipated[k] = run.dissipated[0] + dissipated_within(chain, run.s, now, h, theta)
        film.taken[0] += 1


@jit
def integrate(
    chain: Chain,
    speed: float,
    rtol: float,
    atol: float,
    max_steps: int,
    t_end: float,
    watch: Watch,
    noise: float = 0.0,
) -> Run:
    """Run one impact at `speed` to t_end and keep the peak speed of the middle site.

    noise: size of random first velocities of the sites, over `speed`, with which all sites are integrated.
    """
    reached = 0.0 if noise != 0.0 else REACHED * speed
    settings = Settings(rtol, atol, max_steps, t_end, reached, False)
    run = start(chain, speed, settings, watch)
    if noise != 0.0:  # the accelerations at the start, which are those at rest, are wrong by as little
        disturb(run.s.v, chain.N, noise * speed)
    advance(chain, run, settings, t_end)
    tally, clock = run.tally, run.clock
    evaluations = LAST * tally[TRIED]
    found(chain, speed, run)
    left = energy_at_end(chain, run)
    return Run(tally[STATUS], clock[PEAK], clock[T_PEAK], tally[STEPS], evaluations, tally[SITE_EVALUATIONS], left, 0)


@jit
def energy_at_end(chain: Chain, run: March) -> float:
    """Total energy at the end of the last step."""
    u, v, impactor = end_of_step(run)
    return energy(chain, u, v, impactor[0], impactor[1])


@jit
def _accept(chain: Chain, run: March, reached: float) -> None:
    """Make the end of the last step the start of the next; let in more sites when the wave comes near the last."""
    n, size = run.tally[ACTIVE], padded(chain.N)
    run.tally[NOW] = 1 - run.tally[NOW]
    run.clock[T_FROM] = run.clock[T_TO]
    if n < size:
        here = run.tally[NOW] * size
        for i in range(here + n - WIDTH, here + n):
            if abs(run.s.v[i]) > reached:
                run.tally[ACTIVE] = min(size, n + MORE_SITES)


@jit
def end_of_step(run: March) -> tuple[Array, Array, Array]:
    """Displacements and velocities of the sites (padded) and of the impactor (2,) at the end of the last step."""
    s, then = run.s, 1 - run.tally[NOW]
    size = s.u.shape[0] // 2
    part = slice(then * size, (then + 1) * size)
    return s.u[part], s.v[part], s.impactor[2 * then : 2 * then + 2]


@jit
def velocity_quartic(p: Array, s: State, now: int, h: float, site: int) -> None:
    """Write the continuous extension of the velocity of `site` (from 1) into p[:5] (9,), powers of (t - t_from)/h."""
    size, i = s.u.shape[0] // 2, site - 1
    p[0] = s.v[now * size + i]
    total = splat(0.0)
    for j in range(STAGES):
        total = total + s.k[row(j, now) * size + i] * load(POWERS, WIDTH * j)
    store(p, 1, h * total)


@jit
def state_within(s: State, now: int, h: float, theta: float, u: Array, v: Array) -> tuple[float, float]:
    """Write displacements and velocities of all sites at t_from + theta h into u, v (N,); those of the impactor."""
    size, hh = s.u.shape[0] // 2, h * h
    b, bb = np.zeros(STAGES), np.zeros(STAGES)
    for j in range(STAGES):
        x = INTERPOLANT[j]
        weight = theta * (x[0] + theta * (x[1] + theta * (x[2] + theta * x[3])))
        b[row(j, now)] = weight
        for i in range(j):  # u' = v: the same weights once more through the tableau
            bb[row(i, now)] += weight * A[j, i]
    for i in range(u.shape[0]):
        du, dv = 0.0, 0.0
        for j in range(STAGES):
            du += bb[j] * s.k[j * size + i]
            dv += b[j] * s.k[j * size + i]
        u[i] = s.u[now * size + i] + theta * h * s.v[now * size + i] + hh * du
        v[i] = s.v[now * size + i] + h * dv
    u0, v0 = s.impactor[2 * now], s.impactor[2 * now + 1]
    return u0 + theta * h * v0 + hh * np.sum(bb * s.k_impactor), v0 + h * np.sum(b * s.k_impactor)


@jit
def dissipated_within(chain: Chain, s: State, now: int, h: float, theta: float) -> float:
    """Energy that the dampers take from t_from to t_from + theta h."""
    u, v = np.empty(chain.N), np.empty(chain.N)
    total = 0.0
    for node, weight in zip(NODES, NODE_WEIGHTS):  # noqa: B905 (numba knows no strict)
        state_within(s, now, h, theta * node, u, v)
        total += theta * h * weight * dissipated_power(chain, v)
    return total
