"""One step of Dormand-Prince 5(4): six stages, each one pass over the chain.

A stage forms the displaced state eight sites at a time, takes its accelerations at once and stores only these; the last
one also writes the solution and measures its error. Made by factories because a stage's coefficients are constants, and
inlined because passing the arrays would take as long as a short chain's sites.

Springs see the displacements u, linear springs and dampers together w = u + 2 zeta v: the linear chain needs w alone,
one weighted sum of accelerations where the bistable one needs two, and an undamped chain has w = u. Chains that are not
uniform (kernel.varied) have stages of their own.
"""

from typing import Any

import numpy as np

from kernel import tableau
from kernel.jit import either, inlined, jit, written_out
from kernel.model import Array, Chain
from kernel.simd import (
    WIDTH,
    element,
    larger,
    left_neighbours,
    load,
    magnitude,
    right_neighbours,
    splat,
    store,
)
from kernel.state import LAST, State, padded, row
from kernel.varied import (
    DAMPING,
    HELD,
    LIGHTNESS,
    STIFFNESS,
    VARIED_ROWS,
    as_held,
    as_pushed,
    driven_acceleration,
    is_driven,
)

Weights = tuple[float, ...]

# Where a row begins. A plain 0 would be a type of its own, for which numba would compile the same once more.
BEGIN: Any = np.intp(0)
# Stage 2 has weight 0 in the solution and in its error estimate, of v (rows of A, E) and of u (rows of A A, E A). Of u
# stage 6 has none in the solution either, nor stage 7 in the error, as A A has one diagonal of zeros more than A.
A0, A2, A3, A4, A5 = (float(x) for x in tableau.A[LAST, [0, 2, 3, 4, 5]])
B0, B2, B3, B4 = (float(x) for x in tableau.A_A[LAST, [0, 2, 3, 4]])
E0, E2, E3, E4, E5, E6 = (float(x) for x in tableau.E[[0, 2, 3, 4, 5, 6]])
F0, F2, F3, F4, F5 = (float(x) for x in tableau.E_A[[0, 2, 3, 4, 5]])


@inlined
def _entry(k: Array, i: int) -> float:
    return k[i]


def _make_sum(terms: int, read: Any) -> Any:
    """base + w[0] k[first] + sum_{1 <= m < terms} w[m] k[m], unrolled: of eight sites (load), or of one (_entry).

    What has no weight is not read: it is left from the try before, which may have blown up.
    """

    @written_out
    def _weighted(base: Any, k: Array, first: int, size: int, i: int, w: Weights) -> Any:
        total = base
        if terms > 0:
            total = total + w[0] * read(k, first + i)
        if terms > 1:
            total = total + w[1] * read(k, size + i)
        if terms > 2:
            total = total + w[2] * read(k, 2 * size + i)
        if terms > 3:
            total = total + w[3] * read(k, 3 * size + i)
        if terms > 4:
            total = total + w[4] * read(k, 4 * size + i)
        return total

    return _weighted


def _make_accelerations(bistable: bool, damped: bool) -> Any:
    """The function that takes the accelerations of eight sites from their u and w."""

    @written_out
    def _accelerations(spring: Any, own: Any, i: int, driven: Any, u: Any, w: Any, right: Any, g_before: Any) -> Any:
        """Accelerations of eight sites, and the tensions of the links to their right."""
        g = right_neighbours(w, right[1]) - w
        if bistable:
            g = g + spring.excess(right_neighbours(u, right[0]) - u if damped else g)
        return g - left_neighbours(g_before, g), g

    return _accelerations


@written_out
def _varied_accelerations(spring: Any, own: Any, i: int, driven: Any, u: Any, w: Any, right: Any, g_before: Any) -> Any:
    """The same where sites, links and dampers differ; the first of the eight is at i. own: `Varied.rows`."""
    size = own.shape[0] // VARIED_ROWS
    e, slip = right_neighbours(u, right[0]) - u, right_neighbours(w, right[1]) - w
    g = load(own, STIFFNESS * size + i) * (e + spring.excess(e)) + load(own, DAMPING * size + i) * (slip - e)
    a = load(own, LIGHTNESS * size + i) * (g - left_neighbours(g_before, g))
    return a + driven * load(own, HELD * size + i), g


# Asked once for a pass over the chain, as is the spring: what has arrays in it is counted wherever it is passed, and a
# driver's motion takes time.
@written_out
def _own_rows(chain: Chain, s: State) -> Any:
    return chain.varied.rows


@written_out
def _no_rows(chain: Chain, s: State) -> Any:
    return s.inside


# No step holds more than one piece of a driver's motion, which the middle of the step tells.
@written_out
def _driven(chain: Chain, t: float, c: float, h: float) -> float:
    return driven_acceleration(chain.varied.motion, t + c * h, t + 0.5 * h)


@written_out
def _not_driven(chain: Chain, t: float, c: float, h: float) -> float:
    return 0.0


# A site that a driver holds is where it is told to be, whatever its error seems to be where its acceleration jumps.
@written_out
def _not_held(own: Any, i: int, x: Any) -> Any:
    return x * (splat(1.0) - load(own, HELD * (own.shape[0] // VARIED_ROWS) + i))


@written_out
def _as_it_is(own: Any, i: int, x: Any) -> Any:
    return x


@jit
def begin_piece(varied: Any, s: State, now: int, t: float, h: float) -> None:
    """The first stage of a step is the last one of the step before: a driver may have begun another piece since."""
    if varied is None:
        return
    if varied.motion.top > 0.0:
        a, first = driven_acceleration(varied.motion, t, t + 0.5 * h), row(0, now)
        if varied.motion.holds:
            s.k[first * (s.u.shape[0] // 2)] = a
        else:
            s.k_impactor[first] = a


def _make_stage(stage: int, bistable: bool, damped: bool, uniform: bool) -> Any:
    """The function that computes the accelerations of stage 1 .. 5."""
    c = float(tableau.C[stage])
    a0, a1, a2, a3, a4 = (float(x) for x in tableau.A[stage, :5])
    b0, b1, b2, b3 = (float(x) for x in tableau.A_A[stage, :4])
    sum_u, sum_one, sum_w = _make_sum(stage - 1, load), _make_sum(stage - 1, _entry), _make_sum(stage, load)
    accelerations = _make_accelerations(bistable, damped) if uniform else _varied_accelerations
    own_rows, given = (_no_rows, _not_driven) if uniform else (_own_rows, _driven)

    @inlined
    def _displaced(s: State, here: int, first: int, i: int, ch: float, eta: float, wu: Weights, ww: Weights) -> Any:
        """u and w = u + eta v of eight sites at this stage; one of them twice where the other is not needed."""
        size = s.u.shape[0] // 2
        u, v = load(s.u, here + i), load(s.v, here + i)
        if bistable and damped:
            end = sum_u(u + ch * v, s.k, first, size, i, wu)
            return end, sum_w(u + (ch + eta) * v, s.k, first, size, i, ww)
        if bistable:
            u = sum_u(u + ch * v, s.k, first, size, i, wu)
            return u, u
        w = sum_w(u + (ch + eta) * v, s.k, first, size, i, ww)
        return w, w

    @inlined
    def _evaluate(chain: Chain, s: State, n: int, h: float, now: int, t: float) -> None:
        eta, hh, ch = 2.0 * chain.zeta, h * h, c * h
        wu, he = (hh * b0, hh * b1, hh * b2, hh * b3), h * eta
        ww = (wu[0] + he * a0, wu[1] + he * a1, wu[2] + he * a2, wu[3] + he * a3, he * a4)
        size = padded(chain.N)
        here, first = now * size, row(0, now) * size
        k, kept = s.k, s.k_impactor
        u0 = sum_one(s.impactor[2 * now] + ch * s.impactor[2 * now + 1], kept, row(0, now), 1, 0, wu)
        u0, _ = as_pushed(chain.varied, t + ch, u0, 0.0)
        u, w = _displaced(s, here, first, BEGIN, ch, eta, wu, ww)
        u, w = as_held(chain.varied, t + ch, u, w, 1.0, eta)
        u1 = element(u, 0) if bistable else sum_one(s.u[here] + ch * s.v[here], k, first, size, 0, wu)
        push = chain.contact.push(u0 - u1)
        driven, own, spring = given(chain, t, c, h), own_rows(chain, s), chain.spring
        kept[stage] = -push / chain.impactor_mass + driven
        g, wall = splat(-push), splat(0.0)
        for i in range(0, n, WIDTH):
            u_right, w_right = wall, wall
            if i + WIDTH < n:
                u_right, w_right = _displaced(s, here, first, i + WIDTH, ch, eta, wu, ww)
            a, g = accelerations(spring, own, i, driven, u, w, (u_right, w_right), g)
            if i + WIDTH >= size:  # nothing may move behind the wall
                a = a * load(s.inside, 0)
            store(k, stage * size + i, a)
            u, w = u_right, w_right

    return _evaluate


def _make_last(bistable: bool, damped: bool, uniform: bool) -> Any:
    """The function of stage 6: the solution at the end of the step, its accelerations, and its error."""
    accelerations = _make_accelerations(bistable, damped) if uniform else _varied_accelerations
    own_rows, given = (_no_rows, _not_driven) if uniform else (_own_rows, _driven)
    counted = _as_it_is if uniform else _not_held

    @inlined
    def _solution(s: State, size: int, i: int, h: float, now: int) -> Any:
        """Eight sites at the end of the step, and what the stages before this one say of their errors."""
        k, hh, here, first = s.k, h * h, now * size + i, row(0, now) * size + i
        k0, k2, k3 = load(k, first), load(k, 2 * size + i), load(k, 3 * size + i)
        k4, k5 = load(k, 4 * size + i), load(k, 5 * size + i)
        v, u = load(s.v, here), load(s.u, here)
        u_end = u + h * v + hh * (B0 * k0 + B2 * k2 + B3 * k3 + B4 * k4)
        v_end = v + h * (A0 * k0 + A2 * k2 + A3 * k3 + A4 * k4 + A5 * k5)
        there = (1 - now) * size + i
        store(s.u, there, u_end)
        store(s.v, there, v_end)
        error_u = magnitude(hh * (F0 * k0 + F2 * k2 + F3 * k3 + F4 * k4 + F5 * k5))
        error_v = E0 * k0 + E2 * k2 + E3 * k3 + E4 * k4 + E5 * k5
        size_u, size_v = larger(magnitude(u), magnitude(u_end)), larger(magnitude(v), magnitude(v_end))
        return u_end, v_end, error_u, error_v, size_u, size_v

    @inlined
    def _ratio(h: float, low: Any, end: Any, a: Any, top: Any, trouble: Any) -> Any:
        """The largest error over size so far, and nan as soon as one is not finite, with those of eight sites."""
        error_v = magnitude(h * (end[3] + E6 * a))
        size_u, size_v = larger(end[4], low), larger(end[5], low)
        ratio = larger(end[2] * size_v, error_v * size_u) / (size_u * size_v)  # one division for both
        return larger(ratio, top), trouble + (error_v - error_v)

    @inlined
    def _evaluate(chain: Chain, s: State, n: int, h: float, now: int, threshold: float, t: float) -> float:
        eta, low = 2.0 * chain.zeta, splat(threshold)
        size = padded(chain.N)
        there = row(LAST, now) * size
        end = _solution(s, size, BEGIN, h, now)
        u, v = as_held(chain.varied, t + h, end[0], end[1], 0.0, 1.0)
        store(s.u, (1 - now) * size, u)
        store(s.v, (1 - now) * size, v)
        driven, own, spring = given(chain, t, 1.0, h), own_rows(chain, s), chain.spring
        end = (u, v, counted(own, BEGIN, end[2]), counted(own, BEGIN, end[3]), end[4], end[5])
        largest = _impactor(chain, s, h, now, element(end[0], 0), threshold, driven, t)
        push = chain.contact.push(s.impactor[2 * (1 - now)] - element(end[0], 0))
        g, wall = splat(-push), splat(0.0)
        top, trouble = wall, wall
        w = end[0] + eta * end[1]
        for i in range(0, n, WIDTH):
            right = (wall, wall, wall, wall, wall, wall)
            if i + WIDTH < n:
                right = _solution(s, size, i + WIDTH, h, now)
            w_right = right[0] + eta * right[1]
            a, g = accelerations(spring, own, i, driven, end[0], w, (right[0], w_right), g)
            if i + WIDTH >= size:
                a = a * load(s.inside, 0)
            store(s.k, there + i, a)
            top, trouble = _ratio(h, low, end, counted(own, i, a), top, trouble)
            end, w = right, w_right
        for i in range(WIDTH):
            largest = max(largest, element(top, i)) + element(trouble, i)
        return largest

    return _evaluate


@inlined
def _impactor(
    chain: Chain, s: State, h: float, now: int, u1: float, threshold: float, driven: float, t: float
) -> float:
    """Stage 6 of the impactor, with site 1 at u1; its error over its size, nan where it is not finite."""
    k, hh, then = s.k_impactor, h * h, 1 - now
    k0 = k[row(0, now)]
    u, v = s.impactor[2 * now], s.impactor[2 * now + 1]
    u_end = u + h * v + hh * (B0 * k0 + B2 * k[2] + B3 * k[3] + B4 * k[4])
    v_end = v + h * (A0 * k0 + A2 * k[2] + A3 * k[3] + A4 * k[4] + A5 * k[5])
    u_end, v_end = as_pushed(chain.varied, t + h, u_end, v_end)
    a = -chain.contact.push(u_end - u1) / chain.impactor_mass + driven
    s.impactor[2 * then], s.impactor[2 * then + 1] = u_end, v_end
    k[row(LAST, now)] = a
    if is_driven(chain.varied):
        return 0.0
    error_u = abs(hh * (F0 * k0 + F2 * k[2] + F3 * k[3] + F4 * k[4] + F5 * k[5]))
    error_v = abs(h * (E0 * k0 + E2 * k[2] + E3 * k[3] + E4 * k[4] + E5 * k[5] + E6 * a))
    ratio_u = error_u / max(abs(u), abs(u_end), threshold)
    return max(ratio_u, error_v / max(abs(v), abs(v_end), threshold)) + (error_v - error_v)


def _make_step(bistable: bool, damped: bool, uniform: bool = True) -> Any:
    """The function of all six stages, for one kind of chain."""
    one, two, three, four, five = (_make_stage(stage, bistable, damped, uniform) for stage in range(1, LAST))
    last = _make_last(bistable, damped, uniform)

    @written_out
    def _all_stages(chain: Chain, s: State, n: int, h: float, now: int, threshold: float, t: float) -> float:
        one(chain, s, n, h, now, t)
        two(chain, s, n, h, now, t)
        three(chain, s, n, h, now, t)
        four(chain, s, n, h, now, t)
        five(chain, s, n, h, now, t)
        return last(chain, s, n, h, now, threshold, t)

    return _all_stages


_linear, _damped, _undamped = _make_step(False, True), _make_step(True, True), _make_step(True, False)
_varied = _make_step(True, True, False)


@inlined
def _uniform(chain: Chain, s: State, n: int, h: float, now: int, threshold: float, t: float) -> float:
    if chain.spring.is_linear():
        return _linear(chain, s, n, h, now, threshold, t)
    if chain.zeta > 0.0:
        return _damped(chain, s, n, h, now, threshold, t)
    return _undamped(chain, s, n, h, now, threshold, t)


_all_stages_of = either(_uniform, _varied)


@inlined
def step(varied: Any, chain: Chain, s: State, n: int, t: float, h: float, now: int, threshold: float) -> float:
    """One step of size h from time t of the first n (whole packs) sites, from half `now` to the other half.

    varied: that of the chain. Returns the largest relative difference of the fifth- and the fourth-order solution, as
    ode45 takes it (sizes below `threshold` count as that); nan where the solution is not finite. The first row of k
    must hold the accelerations of half `now`; the last one then holds those of the other.
    """
    return _all_stages_of(varied)(chain, s, n, h, now, threshold, t)
