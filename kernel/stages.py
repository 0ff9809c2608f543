"""One step of Dormand-Prince 5(4): six stages, each one pass over the chain.

A stage forms the displaced state eight sites at a time, takes its accelerations at once and stores only these; the last
one also writes the solution and measures its error. Made by factories because a stage's coefficients are constants.
"""

from typing import Any, NamedTuple

import numpy as np

from kernel import tableau
from kernel.jit import jit
from kernel.model import Array, Chain, contact_force
from kernel.simd import (
    WIDTH,
    element,
    larger,
    left_neighbours,
    load,
    magnitude,
    negative_part,
    right_neighbours,
    splat,
    store,
    zeros,
)

LAST = tableau.STAGES - 1
# The second stage has no weight in the solution and in its error, neither of v nor, through A A, of u.
A0, A2, A3, A4, A5 = (float(x) for x in tableau.A[LAST, [0, 2, 3, 4, 5]])
B0, B2, B3, B4, B5 = (float(x) for x in tableau.A_A[LAST, [0, 2, 3, 4, 5]])
E0, E2, E3, E4, E5, E6 = (float(x) for x in tableau.E[[0, 2, 3, 4, 5, 6]])
F0, F2, F3, F4, F5, F6 = (float(x) for x in tableau.E_A[[0, 2, 3, 4, 5, 6]])


class State(NamedTuple):
    """The chain at both ends of a step: half `now` (0 or 1) is its start, the other half its end.

    Arrays of sites are padded with zeros, the wall. Where the next step begins, the halves change their roles, and so
    do the first and the last row of accelerations (first same as last): nothing is copied.
    """

    u: Array  # (2 padded(N),) displacements, site i at i - 1 of its half
    v: Array  # (2 padded(N),) velocities
    k: Array  # (7 padded(N),) accelerations of the stages, row after row
    impactor: Array  # (4,): u_0, v_0 of half 0, of half 1
    k_impactor: Array  # (7,)
    inside: Array  # (8,): 1 for the sites of the last pack that are before the wall, else 0


@jit
def padded(N: int) -> int:
    """Length of a row of sites: whole packs."""
    return (N + WIDTH - 1) // WIDTH * WIDTH


@jit
def new_state(N: int, speed: float) -> State:
    """Everything at rest and unstrained but the impactor."""
    n = padded(N)
    impactor, inside = np.zeros(4), zeros(WIDTH)
    impactor[1] = speed
    inside[: N - (n - WIDTH)] = 1.0
    return State(zeros(2 * n), zeros(2 * n), zeros(tableau.STAGES * n), impactor, np.zeros(tableau.STAGES), inside)


@jit
def row(stage: int, now: int) -> int:
    """Which row of accelerations belongs to a stage."""
    return LAST - stage if now == 1 and stage in (0, LAST) else stage


def _make_sum(terms: int) -> Any:
    """w0 k[first] + sum_{1 <= m < terms} wm k[m] over eight sites, unrolled."""

    @jit
    def _weighted(
        k: Array, first: int, size: int, i: int, w0: float, w1: float, w2: float, w3: float, w4: float
    ) -> Any:
        total = w0 * load(k, first + i)
        if terms > 1:
            total = total + w1 * load(k, size + i)
        if terms > 2:
            total = total + w2 * load(k, 2 * size + i)
        if terms > 3:
            total = total + w3 * load(k, 3 * size + i)
        if terms > 4:
            total = total + w4 * load(k, 4 * size + i)
        return total

    return _weighted


def _make_stage(stage: int, damped: bool) -> Any:
    """The function that computes the accelerations of stage 1 .. 5; an undamped chain needs no velocities."""
    c = float(tableau.C[stage])
    a0, a1, a2, a3, a4 = (float(x) for x in tableau.A[stage, :5])
    b0, b1, b2, b3, b4 = (float(x) for x in tableau.A_A[stage, :5])
    weighted = _make_sum(stage)

    @jit
    def _evaluate(chain: Chain, s: State, n: int, h: float, now: int) -> None:
        c2, c3, eta, hh, ch = chain.c2, chain.c3, 2.0 * chain.zeta, h * h, c * h
        size = padded(chain.N)
        here, first = now * size, row(0, now) * size
        k, kept = s.k, s.k_impactor
        u0 = s.impactor[2 * now] + ch * s.impactor[2 * now + 1]
        u0 += hh * (b0 * kept[row(0, now)] + b1 * kept[1] + b2 * kept[2] + b3 * kept[3] + b4 * kept[4])
        v = load(s.v, here)
        u = load(s.u, here) + ch * v
        u = u + weighted(k, first, size, 0, hh * b0, hh * b1, hh * b2, hh * b3, hh * b4)
        if damped:
            v = v + weighted(k, first, size, 0, h * a0, h * a1, h * a2, h * a3, h * a4)
        push = contact_force(chain.K, u0 - element(u, 0))
        kept[stage] = -push / chain.impactor_mass
        g_before, wall = splat(-push), splat(0.0)
        for i in range(0, n, WIDTH):
            j = i + WIDTH
            u_right, v_right = wall, wall
            if j < n:
                v_right = load(s.v, here + j)
                u_right = load(s.u, here + j) + ch * v_right
                u_right = u_right + weighted(k, first, size, j, hh * b0, hh * b1, hh * b2, hh * b3, hh * b4)
                if damped:
                    v_right = v_right + weighted(k, first, size, j, h * a0, h * a1, h * a2, h * a3, h * a4)
            e = right_neighbours(u, u_right) - u
            m = negative_part(e)
            g = e + m * m * (c2 + c3 * m)
            if damped:
                g = g + eta * (right_neighbours(v, v_right) - v)
            a = g - left_neighbours(g_before, g)
            if j >= size:  # nothing may move behind the wall
                a = a * load(s.inside, 0)
            store(k, stage * size + i, a)
            g_before, u, v = g, u_right, v_right

    return _evaluate


def _make_last(damped: bool) -> Any:
    """The function of stage 6: the solution at the end of the step, its accelerations, and its error."""

    @jit
    def _solution(s: State, size: int, i: int, h: float, now: int) -> Any:
        """Eight sites at the end of the step, and what the stages before this one say of their errors."""
        k, hh, here, first = s.k, h * h, now * size + i, row(0, now) * size + i
        k0, k2, k3 = load(k, first), load(k, 2 * size + i), load(k, 3 * size + i)
        k4, k5 = load(k, 4 * size + i), load(k, 5 * size + i)
        v, u = load(s.v, here), load(s.u, here)
        u_end = u + h * v + hh * (B0 * k0 + B2 * k2 + B3 * k3 + B4 * k4 + B5 * k5)
        v_end = v + h * (A0 * k0 + A2 * k2 + A3 * k3 + A4 * k4 + A5 * k5)
        there = (1 - now) * size + i
        store(s.u, there, u_end)
        store(s.v, there, v_end)
        error_u = F0 * k0 + F2 * k2 + F3 * k3 + F4 * k4 + F5 * k5
        error_v = E0 * k0 + E2 * k2 + E3 * k3 + E4 * k4 + E5 * k5
        size_u, size_v = larger(magnitude(u), magnitude(u_end)), larger(magnitude(v), magnitude(v_end))
        return u_end, v_end, error_u, error_v, size_u, size_v

    @jit
    def _evaluate(chain: Chain, s: State, n: int, h: float, now: int, threshold: float) -> float:
        c2, c3, eta, hh, low = chain.c2, chain.c3, 2.0 * chain.zeta, h * h, splat(threshold)
        size = padded(chain.N)
        there = row(LAST, now) * size
        u, v, error_u, error_v, size_u, size_v = _solution(s, size, 0, h, now)
        largest = _impactor(chain, s, h, now, element(u, 0), threshold)
        push = contact_force(chain.K, s.impactor[2 * (1 - now)] - element(u, 0))
        g_before, wall = splat(-push), splat(0.0)
        top, trouble = wall, wall
        for i in range(0, n, WIDTH):
            right = (wall, wall, wall, wall, wall, wall)
            if i + WIDTH < n:
                right = _solution(s, size, i + WIDTH, h, now)
            e = right_neighbours(u, right[0]) - u
            m = negative_part(e)
            g = e + m * m * (c2 + c3 * m)
            if damped:
                g = g + eta * (right_neighbours(v, right[1]) - v)
            a = g - left_neighbours(g_before, g)
            if i + WIDTH >= size:
                a = a * load(s.inside, 0)
            store(s.k, there + i, a)
            error_u, error_v = magnitude(hh * (error_u + F6 * a)), magnitude(h * (error_v + E6 * a))
            size_u, size_v = larger(size_u, low), larger(size_v, low)
            ratio = larger(error_u * size_v, error_v * size_u) / (size_u * size_v)  # one division for both
            trouble = trouble + (error_v - error_v)  # nan as soon as one is not finite
            top = larger(ratio, top)
            g_before = g
            u, v, error_u, error_v, size_u, size_v = right
        for i in range(WIDTH):
            largest = max(largest, element(top, i)) + element(trouble, i)
        return largest

    return _evaluate


@jit
def _impactor(chain: Chain, s: State, h: float, now: int, u1: float, threshold: float) -> float:
    """Stage 6 of the impactor, with site 1 at u1; its error over its size, nan where it is not finite."""
    k, hh, then = s.k_impactor, h * h, 1 - now
    k0 = k[row(0, now)]
    u, v = s.impactor[2 * now], s.impactor[2 * now + 1]
    u_end = u + h * v + hh * (B0 * k0 + B2 * k[2] + B3 * k[3] + B4 * k[4] + B5 * k[5])
    v_end = v + h * (A0 * k0 + A2 * k[2] + A3 * k[3] + A4 * k[4] + A5 * k[5])
    a = -contact_force(chain.K, u_end - u1) / chain.impactor_mass
    s.impactor[2 * then], s.impactor[2 * then + 1] = u_end, v_end
    k[row(LAST, now)] = a
    error_u = abs(hh * (F0 * k0 + F2 * k[2] + F3 * k[3] + F4 * k[4] + F5 * k[5] + F6 * a))
    error_v = abs(h * (E0 * k0 + E2 * k[2] + E3 * k[3] + E4 * k[4] + E5 * k[5] + E6 * a))
    ratio_u = error_u / max(abs(u), abs(u_end), threshold)
    return max(ratio_u, error_v / max(abs(v), abs(v_end), threshold)) + (error_v - error_v)


_d1, _d2, _d3, _d4, _d5 = (_make_stage(stage, True) for stage in range(1, LAST))
_f1, _f2, _f3, _f4, _f5 = (_make_stage(stage, False) for stage in range(1, LAST))
_d6, _f6 = _make_last(True), _make_last(False)


@jit
def step(chain: Chain, s: State, n: int, h: float, now: int, threshold: float) -> float:
    """One step of size h of the first n (whole packs) sites, from half `now` to the other half.

    Returns the largest relative difference of the fifth- and the fourth-order solution, as ode45 takes it (sizes below
    `threshold` count as that); nan where the solution is not finite. The first row of k must hold the accelerations of
    half `now`; the last one then holds those of the other.
    """
    if chain.zeta > 0.0:
        _d1(chain, s, n, h, now)
        _d2(chain, s, n, h, now)
        _d3(chain, s, n, h, now)
        _d4(chain, s, n, h, now)
        _d5(chain, s, n, h, now)
        return _d6(chain, s, n, h, now, threshold)
    _f1(chain, s, n, h, now)
    _f2(chain, s, n, h, now)
    _f3(chain, s, n, h, now)
    _f4(chain, s, n, h, now)
    _f5(chain, s, n, h, now)
    return _f6(chain, s, n, h, now, threshold)
