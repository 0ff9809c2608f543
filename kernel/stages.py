"""The six stages of Dormand-Prince 5(4), each one pass over the chain.

A stage forms the displaced state eight sites at a time, takes its accelerations at once and stores only these: nothing
but the last stage, the solution, is written back. Made by a factory because a stage's coefficients are constants.
"""

from typing import Any, NamedTuple

import numpy as np

from kernel import tableau
from kernel.jit import jit
from kernel.model import Array, Chain, contact_force
from kernel.simd import (
    WIDTH,
    element,
    left_neighbours,
    load,
    negative_part,
    right_neighbours,
    splat,
    store,
    zeros,
)

LAST = tableau.STAGES - 1


class State(NamedTuple):
    """Where the chain is, and the work arrays of a step. Arrays of sites are padded with zeros, the wall."""

    u: Array  # displacements, site i at i - 1
    v: Array  # velocities
    u_next: Array  # the same at the end of the step
    v_next: Array
    k: Array  # accelerations of the seven stages, one after the other
    impactor: Array  # (4,): u_0, v_0 and the same at the end of the step
    k_impactor: Array  # (7,)


@jit
def padded(N: int) -> int:
    """Length of the site arrays: whole packs."""
    return (N + WIDTH - 1) // WIDTH * WIDTH


@jit
def new_state(N: int, speed: float) -> State:
    """Everything at rest and unstrained but the impactor."""
    n = padded(N)
    impactor = np.zeros(4)
    impactor[1] = speed
    return State(zeros(n), zeros(n), zeros(n), zeros(n), zeros(tableau.STAGES * n), impactor, np.zeros(tableau.STAGES))


def _make_sum(terms: int) -> Any:
    """sum_{m < terms} w[m] k[m] over eight sites, unrolled."""

    @jit
    def weighted(k: Array, n: int, i: int, w0: float, w1: float, w2: float, w3: float, w4: float, w5: float) -> Any:
        total = w0 * load(k, i)
        if terms > 1:
            total = total + w1 * load(k, n + i)
        if terms > 2:
            total = total + w2 * load(k, 2 * n + i)
        if terms > 3:
            total = total + w3 * load(k, 3 * n + i)
        if terms > 4:
            total = total + w4 * load(k, 4 * n + i)
        if terms > 5:
            total = total + w5 * load(k, 5 * n + i)
        return total

    return weighted


def _make_stage(stage: int, damped: bool) -> Any:
    """The function that computes the accelerations of stage `stage`; an undamped chain needs no velocities."""
    c = float(tableau.C[stage])
    a0, a1, a2, a3, a4, a5 = (float(x) for x in tableau.A[stage, :6])
    b0, b1, b2, b3, b4, b5 = (float(x) for x in tableau.A_A[stage, :6])
    last = stage == LAST
    velocities = damped or last
    weighted = _make_sum(stage)

    @jit
    def evaluate(chain: Chain, s: State, n: int, h: float) -> None:
        N, c2, c3, eta = chain.N, chain.c2, chain.c3, 2.0 * chain.zeta
        hh, ch = h * h, c * h
        k, now = s.k, s.k_impactor
        u0 = s.impactor[0] + ch * s.impactor[1]
        u0 += hh * (b0 * now[0] + b1 * now[1] + b2 * now[2] + b3 * now[3] + b4 * now[4] + b5 * now[5])
        u = load(s.u, 0) + ch * load(s.v, 0)
        size = padded(N)
        u = u + weighted(k, size, 0, hh * b0, hh * b1, hh * b2, hh * b3, hh * b4, hh * b5)
        v = load(s.v, 0)
        if velocities:
            v = v + weighted(k, size, 0, h * a0, h * a1, h * a2, h * a3, h * a4, h * a5)
        push = contact_force(chain.K, u0 - element(u, 0))
        s.k_impactor[stage] = -push / chain.impactor_mass
        if last:
            s.impactor[2] = u0
            s.impactor[3] = s.impactor[1] + h * (
                a0 * now[0] + a1 * now[1] + a2 * now[2] + a3 * now[3] + a4 * now[4] + a5 * now[5]
            )
        g_before, wall = splat(-push), splat(0.0)
        for i in range(0, n, WIDTH):
            j = i + WIDTH
            u_right, v_right = wall, wall
            if j < n:
                u_right = load(s.u, j) + ch * load(s.v, j)
                u_right = u_right + weighted(k, size, j, hh * b0, hh * b1, hh * b2, hh * b3, hh * b4, hh * b5)
                if velocities:
                    v_right = load(s.v, j) + weighted(k, size, j, h * a0, h * a1, h * a2, h * a3, h * a4, h * a5)
            e = right_neighbours(u, u_right) - u
            m = negative_part(e)
            g = e + m * m * (c2 + c3 * m)
            if damped:
                g = g + eta * (right_neighbours(v, v_right) - v)
            store(k, stage * size + i, g - left_neighbours(g_before, g))
            if last:
                store(s.u_next, i, u)
                store(s.v_next, i, v)
            g_before, u, v = g, u_right, v_right
        for i in range(N, n):  # nothing may move behind the wall
            k[stage * size + i] = 0.0

    return evaluate


_DAMPED = tuple(_make_stage(stage, True) for stage in range(1, tableau.STAGES))
_FREE = tuple(_make_stage(stage, False) for stage in range(1, tableau.STAGES))
_d1, _d2, _d3, _d4, _d5, _d6 = _DAMPED
_f1, _f2, _f3, _f4, _f5, _f6 = _FREE


@jit
def step(chain: Chain, s: State, n: int, h: float) -> None:
    """One step of size h of the first n (whole packs) sites; s.k[0] must hold the first acceleration.

    Leaves the solution in u_next, v_next, impactor[2:] and its acceleration in k[6] (first same as last).
    """
    if chain.zeta > 0.0:
        _d1(chain, s, n, h)
        _d2(chain, s, n, h)
        _d3(chain, s, n, h)
        _d4(chain, s, n, h)
        _d5(chain, s, n, h)
        _d6(chain, s, n, h)
    else:
        _f1(chain, s, n, h)
        _f2(chain, s, n, h)
        _f3(chain, s, n, h)
        _f4(chain, s, n, h)
        _f5(chain, s, n, h)
        _f6(chain, s, n, h)
