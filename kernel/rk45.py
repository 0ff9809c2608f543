"""Dormand-Prince 5(4) with ode45's step control: the paper's integrator and the reference method.

The arithmetic of one step is `step`; `integrate` chooses the steps and keeps the books.
"""

import math
from typing import NamedTuple

import numpy as np

from kernel import tableau
from kernel.jit import jit
from kernel.model import T_END_OVER_N, Array, Chain, acceleration, dissipated_power, energy
from kernel.peak import peak_of_quartic
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET, STEP_TOO_SMALL

A, A_A, B, C, E, E_A = tableau.A, tableau.A_A, tableau.B, tableau.C, tableau.E, tableau.E_A
INTERPOLANT, STAGES = tableau.INTERPOLANT, tableau.STAGES
POWER = 1.0 / tableau.ORDER


class Outcome(NamedTuple):
    """What one integration tells. Energies and times in the units of kernel.model."""

    status: int  # kernel.status code
    peak_speed: float  # max |v_mid| over continuous time
    t_peak: float  # when
    steps: int  # accepted steps
    evaluations: int  # force evaluations of the whole chain
    energy_end: float  # total energy at the end (nan unless asked for)
    dissipated: float  # energy taken by the dampers (nan unless asked for)


class State(NamedTuple):
    """Work arrays of one integration."""

    u: Array  # (N+1,) displacements
    v: Array  # (N+1,) velocities
    u_next: Array  # (N+1,)
    v_next: Array  # (N+1,)
    k: Array  # (7, N+1) accelerations of the stages
    scratch: Array  # (N+1,)
    power: Array  # (7,) dissipated power of the stages


@jit
def new_state(N: int) -> State:
    """Everything at rest and unstrained."""
    n = N + 1
    return State(
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((STAGES, n)), np.zeros(n), np.zeros(STAGES)
    )


@jit
def _combine(out: Array, base: Array, c: float, slope: Array, scale: float, w: Array, k: Array, terms: int) -> None:
    """out = base + c slope + scale sum_{j < terms} w[j] k[j]; one pass per number of terms: it vectorises."""
    n = base.shape[0]
    k0, k1, k2, k3, k4, k5 = k[0], k[1], k[2], k[3], k[4], k[5]
    w0, w1, w2, w3, w4, w5 = scale * w[0], scale * w[1], scale * w[2], scale * w[3], scale * w[4], scale * w[5]
    if terms == 1:
        for i in range(n):
            out[i] = base[i] + (c * slope[i] + w0 * k0[i])
    elif terms == 2:
        for i in range(n):
            out[i] = base[i] + (c * slope[i] + w0 * k0[i] + w1 * k1[i])
    elif terms == 3:
        for i in range(n):
            out[i] = base[i] + (c * slope[i] + w0 * k0[i] + w1 * k1[i] + w2 * k2[i])
    elif terms == 4:
        for i in range(n):
            out[i] = base[i] + (c * slope[i] + w0 * k0[i] + w1 * k1[i] + w2 * k2[i] + w3 * k3[i])
    elif terms == 5:
        for i in range(n):
            out[i] = base[i] + (c * slope[i] + w0 * k0[i] + w1 * k1[i] + w2 * k2[i] + w3 * k3[i] + w4 * k4[i])
    else:
        for i in range(n):
            out[i] = base[i] + (
                c * slope[i] + w0 * k0[i] + w1 * k1[i] + w2 * k2[i] + w3 * k3[i] + w4 * k4[i] + w5 * k5[i]
            )


@jit
def step(chain: Chain, s: State, h: float, watch_power: bool) -> None:
    """One step of size h from (s.u, s.v) to (s.u_next, s.v_next); s.k[0] must hold the first acceleration.

    Leaves the acceleration at the new state in s.k[6] (first same as last).
    """
    for j in range(1, STAGES):
        _combine(s.u_next, s.u, C[j] * h, s.v, h * h, A_A[j], s.k, j)
        _combine(s.v_next, s.v, 0.0, s.v, h, A[j], s.k, j)
        acceleration(chain, s.u_next, s.v_next, s.scratch, s.k[j])
        if watch_power:
            s.power[j] = dissipated_power(chain, s.v_next)


@jit
def _ratios(out: Array, scale: float, w: Array, k: Array, before: Array, after: Array, threshold: float) -> None:
    """Error of each component over its size, the threshold at least."""
    k0, k2, k3, k4, k5, k6 = k[0], k[2], k[3], k[4], k[5], k[6]  # w[1] is zero
    w0, w2, w3, w4, w5, w6 = w[0], w[2], w[3], w[4], w[5], w[6]
    for i in range(before.shape[0]):
        error = w0 * k0[i] + w2 * k2[i] + w3 * k3[i] + w4 * k4[i] + w5 * k5[i] + w6 * k6[i]
        x, y = abs(before[i]), abs(after[i])
        larger = x if x > y else y
        out[i] = scale * abs(error) / (larger if larger > threshold else threshold)


@jit
def _largest(x: Array) -> float:
    """Maximum of non-negative numbers, nan counting as the largest.

    Their bit patterns order like the numbers, and an integer maximum vectorises without any fast-math flag.
    """
    bits = x.view(np.int64)
    top = bits[0]
    for i in range(bits.shape[0]):
        top = max(top, bits[i])
    bits[0] = top
    return x[0]


@jit
def error_norm(s: State, h: float, threshold: float) -> float:
    """Largest relative difference between the fifth- and the fourth-order solution, as ode45 takes it."""
    _ratios(s.scratch, h * h, E_A, s.k, s.u, s.u_next, threshold)
    of_u = _largest(s.scratch)
    _ratios(s.scratch, h, E, s.k, s.v, s.v_next, threshold)
    of_v = _largest(s.scratch)
    return of_u if of_u > of_v else of_v


@jit
def velocity_quartic(p: Array, s: State, h: float, site: int) -> None:
    """Write the continuous extension of v[site] over the step into p (5,), powers of (t - t_n)/h."""
    p[0] = s.v[site]
    for order in range(4):
        total = 0.0
        for j in range(STAGES):
            total += s.k[j, site] * INTERPOLANT[j, order]
        p[order + 1] = h * total


@jit
def _first_step(s: State, speed: float, h_max: float, rtol: float, threshold: float) -> float:
    """ode45's: only u_0 moves at first, and it moves at the impact speed."""
    return min(h_max, 0.8 * rtol**POWER * max(abs(s.u[0]), threshold) / speed)


@jit
def _accept(s: State) -> None:
    s.u[:] = s.u_next
    s.v[:] = s.v_next
    s.k[0] = s.k[6]


@jit
def integrate(chain: Chain, speed: float, rtol: float, atol: float, max_steps: int, watch_energy: bool) -> Outcome:
    """Run one impact at `speed` to t = 2.25 N and keep the peak speed of the middle site."""
    s, p = new_state(chain.N), np.zeros(5)
    middle, t_end = (chain.N + 1) // 2, T_END_OVER_N * chain.N
    threshold, h_max = atol / rtol, 0.1 * t_end
    s.v[0] = speed
    acceleration(chain, s.u, s.v, s.scratch, s.k[0])
    h = _first_step(s, speed, h_max, rtol, threshold)
    t, peak, t_peak, dissipated, status = 0.0, 0.0, 0.0, 0.0, DONE
    steps, tries, failed = 0, 0, False
    while t < t_end:
        h_min = 16.0 * np.spacing(t)
        last = t + 1.0001 * h >= t_end
        h = t_end - t if last else h
        step(chain, s, h, watch_energy)
        tries += 1
        error = error_norm(s, h, threshold)
        if error <= rtol:
            velocity_quartic(p, s, h, middle)
            peak, at = peak_of_quartic(p, peak)
            t_peak = t + at * h if at >= 0.0 else t_peak
            if watch_energy:
                s.power[0] = dissipated_power(chain, s.v)
                dissipated += h * np.sum(B * s.power)
            _accept(s)
            t = t_end if last else t + h
            steps += 1
            growth = 0.8 * (rtol / error) ** POWER if error > 0.0 else 5.0
            h = min(h_max, h * (1.0 if failed else min(5.0, growth)))
            failed = False
        else:
            shrink = 0.8 * (rtol / error) ** POWER if math.isfinite(error) else 0.1
            h *= 0.5 if failed else max(0.1, shrink)
            failed = True
            if h < h_min:
                status = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
                break
        if tries >= max_steps:
            status = STEP_BUDGET if t < t_end else DONE
            break
    left = energy(chain, s.u, s.v) if watch_energy else np.nan
    return Outcome(status, peak, t_peak, steps, 1 + 6 * tries, left, dissipated if watch_energy else np.nan)
