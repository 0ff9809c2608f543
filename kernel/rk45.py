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
from kernel.jit import jit
from kernel.model import Array, Chain, dissipated_power, energy
from kernel.peak import peak_of_quartic
from kernel.simd import (
    WIDTH,
    element,
    flush_subnormals,
    larger,
    load,
    magnitude,
    restore_subnormals,
    splat,
    store,
)
from kernel.stages import LAST, State, new_state, padded, step
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET, STEP_TOO_SMALL

A, INTERPOLANT, STAGES = tableau.A, tableau.INTERPOLANT, tableau.STAGES
E0, E2, E3, E4, E5, E6 = (float(x) for x in tableau.E[[0, 2, 3, 4, 5, 6]])  # E[1] is zero, and so is E_A[1]
F0, F2, F3, F4, F5, F6 = (float(x) for x in tableau.E_A[[0, 2, 3, 4, 5, 6]])
POWER = 1.0 / tableau.ORDER
REACHED = 1e-16  # of the impact speed: a slower site counts as not yet reached by the wave
FIRST_SITES, MORE_SITES = 16, 16
SMALLEST_STEP = 1e-30  # at t = 0, where ode45's bound is a subnormal
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


class Run(NamedTuple):
    """One run under way. After `advance`, [t_from, t] is the last step."""

    s: State
    clock: Array  # (5,): t_from, t, next step, peak speed of the middle site, its time
    dissipated: Array  # (2,): energy that the dampers took until t_from, and until t
    tally: NDArray[np.int64]  # (5,): status, accepted steps, tried steps, site evaluations, active sites


T_FROM, T, H, PEAK, T_PEAK = range(5)
STATUS, STEPS, TRIED, SITE_EVALUATIONS, ACTIVE = range(5)


class Outcome(NamedTuple):
    """What one integration tells. Energies and times in the units of kernel.model."""

    status: int  # kernel.status code
    peak_speed: float  # max |v_mid| over continuous time
    t_peak: float  # when
    steps: int  # accepted steps
    evaluations: int  # force evaluations of the chain
    site_evaluations: int  # the same, counting only the sites that the wave had reached
    energy_end: float  # total energy at the end (nan unless asked for)
    dissipated: float  # energy taken by the dampers (nan unless asked for)


@jit
def start(chain: Chain, speed: float, settings: Settings) -> Run:
    """At rest and unstrained but the impactor: nothing touches yet, so every acceleration is zero."""
    run = Run(new_state(chain.N, speed), np.zeros(5), np.zeros(2), np.zeros(5, np.int64))
    # ode45's first step: only u_0 moves at first, and it moves at the impact speed.
    run.clock[H] = min(0.1 * settings.t_end, 0.8 * settings.rtol**POWER * settings.atol / settings.rtol / speed)
    run.tally[ACTIVE] = min(padded(chain.N), FIRST_SITES) if settings.reached > 0.0 else padded(chain.N)
    return run


@jit
def advance(chain: Chain, run: Run, settings: Settings, t_stop: float) -> None:
    """Step until the last step ends at or after t_stop (t_end at most), or until the status is not DONE."""
    s, clock, tally, p = run.s, run.clock, run.tally, np.zeros(5)
    middle, t_end, h_max = (chain.N + 1) // 2, settings.t_end, 0.1 * settings.t_end
    threshold = settings.atol / settings.rtol
    word = flush_subnormals()
    failed = False
    while clock[T] < min(t_stop, t_end) and tally[STATUS] == DONE:
        if clock[T] > clock[T_FROM]:
            _accept(chain, run, settings.reached)
        t, h, n = clock[T_FROM], clock[H], tally[ACTIVE]
        last = t + 1.0001 * h >= t_end
        h = t_end - t if last else h
        step(chain, s, n, h)
        tally[TRIED] += 1
        tally[SITE_EVALUATIONS] += LAST * min(n, chain.N)
        error = error_norm(s, n, h, threshold)
        if error <= settings.rtol:
            clock[T] = t_end if last else t + h
            tally[STEPS] += 1
            velocity_quartic(p, s, h, middle)
            clock[PEAK], at = peak_of_quartic(p, clock[PEAK])
            clock[T_PEAK] = t + at * h if at >= 0.0 else clock[T_PEAK]
            if settings.watch_energy:
                run.dissipated[0] = run.dissipated[1]
                run.dissipated[1] += dissipated_within(chain, s, h, 1.0)
            growth = 0.8 * (settings.rtol / error) ** POWER if error > 0.0 else 5.0
            clock[H] = min(h_max, h * (1.0 if failed else min(5.0, growth)))
            failed = False
        else:
            shrink = 0.8 * (settings.rtol / error) ** POWER if math.isfinite(error) else 0.1
            clock[H] = h * (0.5 if failed else max(0.1, shrink))
            failed = True
            if clock[H] < max(16.0 * np.spacing(t), SMALLEST_STEP):
                tally[STATUS] = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        if tally[TRIED] >= settings.max_steps and clock[T] < t_end:
            tally[STATUS] = STEP_BUDGET
    restore_subnormals(word)


@jit
def integrate(
    chain: Chain,
    speed: float,
    rtol: float,
    atol: float,
    max_steps: int,
    t_end: float,
    watch_energy: bool = False,
    all_sites: bool = False,
) -> Outcome:
    """Run one impact at `speed` to t_end and keep the peak speed of the middle site."""
    settings = Settings(rtol, atol, max_steps, t_end, 0.0 if all_sites else REACHED * speed, watch_energy)
    run = start(chain, speed, settings)
    advance(chain, run, settings, t_end)
    s, tally = run.s, run.tally
    left = energy(chain, s.u_next, s.v_next, s.impactor[2], s.impactor[3]) if watch_energy else np.nan
    return Outcome(
        tally[STATUS],
        run.clock[PEAK],
        run.clock[T_PEAK],
        tally[STEPS],
        LAST * tally[TRIED],
        tally[SITE_EVALUATIONS],
        left,
        run.dissipated[1] if watch_energy else np.nan,
    )


@jit
def _accept(chain: Chain, run: Run, reached: float) -> None:
    """Make the end of the last step the start of the next; let in more sites when the wave comes near the last."""
    s, n, size = run.s, run.tally[ACTIVE], padded(chain.N)
    for i in range(0, n, WIDTH):
        store(s.u, i, load(s.u_next, i))
        store(s.v, i, load(s.v_next, i))
        store(s.k, i, load(s.k, LAST * size + i))
    s.impactor[0], s.impactor[1] = s.impactor[2], s.impactor[3]
    s.k_impactor[0] = s.k_impactor[LAST]
    run.clock[T_FROM] = run.clock[T]
    if n < size and _top(magnitude(load(s.v, n - WIDTH)), 0.0) > reached:
        run.tally[ACTIVE] = min(size, n + MORE_SITES)


@jit
def _top(x: Any, top: float) -> float:
    """The largest of eight and `top`."""
    for i in range(WIDTH):
        top = max(top, element(x, i))
    return top


@jit
def error_norm(s: State, n: int, h: float, threshold: float) -> float:
    """Largest relative difference of fifth- and fourth-order solution, as ode45 takes it; nan if one is not finite."""
    k, size, hh, low = s.k, s.u.shape[0], h * h, splat(threshold)
    top, trouble = splat(0.0), splat(0.0)
    for i in range(0, n, WIDTH):
        k0, k2, k3 = load(k, i), load(k, 2 * size + i), load(k, 3 * size + i)
        k4, k5, k6 = load(k, 4 * size + i), load(k, 5 * size + i), load(k, 6 * size + i)
        error_u = magnitude(hh * (F0 * k0 + F2 * k2 + F3 * k3 + F4 * k4 + F5 * k5 + F6 * k6))
        error_v = magnitude(h * (E0 * k0 + E2 * k2 + E3 * k3 + E4 * k4 + E5 * k5 + E6 * k6))
        u = larger(larger(magnitude(load(s.u, i)), magnitude(load(s.u_next, i))), low)
        v = larger(larger(magnitude(load(s.v, i)), magnitude(load(s.v_next, i))), low)
        ratio = larger(error_u * v, error_v * u) / (u * v)  # one division for both
        trouble = trouble + (error_v - error_v)  # nan as soon as one is not finite
        top = larger(ratio, top)
    k = s.k_impactor
    error_u = abs(hh * (F0 * k[0] + F2 * k[2] + F3 * k[3] + F4 * k[4] + F5 * k[5] + F6 * k[6]))
    error_v = abs(h * (E0 * k[0] + E2 * k[2] + E3 * k[3] + E4 * k[4] + E5 * k[5] + E6 * k[6]))
    u = max(abs(s.impactor[0]), abs(s.impactor[2]), threshold)
    v = max(abs(s.impactor[1]), abs(s.impactor[3]), threshold)
    largest = _top(top, max(error_u / u, error_v / v))
    for i in range(WIDTH):
        largest += element(trouble, i)
    return largest + (error_v - error_v)


@jit
def velocity_quartic(p: Array, s: State, h: float, site: int) -> None:
    """Write the continuous extension of the velocity of `site` (from 1) into p (5,), powers of (t - t_from)/h."""
    p[0] = s.v[site - 1]
    size = s.u.shape[0]
    for order in range(4):
        total = 0.0
        for j in range(STAGES):
            total += s.k[j * size + site - 1] * INTERPOLANT[j, order]
        p[order + 1] = h * total


@jit
def state_within(s: State, h: float, theta: float, u: Array, v: Array) -> tuple[float, float]:
    """Write displacements and velocities of all sites at t_from + theta h into u, v (N,); those of the impactor."""
    size, hh = s.u.shape[0], h * h
    b, bb = np.zeros(STAGES), np.zeros(STAGES)
    for j in range(STAGES):
        x = INTERPOLANT[j]
        b[j] = theta * (x[0] + theta * (x[1] + theta * (x[2] + theta * x[3])))
    for j in range(STAGES):  # u' = v: the same weights once more through the tableau
        for i in range(j):
            bb[i] += b[j] * A[j, i]
    for i in range(u.shape[0]):
        du, dv = 0.0, 0.0
        for j in range(STAGES):
            du += bb[j] * s.k[j * size + i]
            dv += b[j] * s.k[j * size + i]
        u[i] = s.u[i] + theta * h * s.v[i] + hh * du
        v[i] = s.v[i] + h * dv
    u0 = s.impactor[0] + theta * h * s.impactor[1] + hh * np.sum(bb * s.k_impactor)
    return u0, s.impactor[1] + h * np.sum(b * s.k_impactor)


@jit
def dissipated_within(chain: Chain, s: State, h: float, theta: float) -> float:
    """Energy that the dampers take from t_from to t_from + theta h."""
    u, v = np.empty(chain.N), np.empty(chain.N)
    total = 0.0
    for node, weight in zip(NODES, NODE_WEIGHTS):  # noqa: B905 (numba knows no strict)
        state_within(s, h, theta * node, u, v)
        total += theta * h * weight * dissipated_power(chain, v)
    return total
