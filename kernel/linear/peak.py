"""The maximum of the squared velocity over continuous time, from samples of the middle site.

Equal steps give displacements (the march in site space), unequal steps give velocities (the modes).
"""

import math

import numpy as np

from kernel.jit import unfused_jit
from kernel.model import Array
from kernel.simd import WIDTH, load, splat, store, zeros

HALF = 7  # samples on each side that an interpolant uses; as many lead and follow the samples of interest
POINTS = 2 * HALF + 1
MONOMIALS = np.linalg.inv(
    np.vander(np.arange(-HALF, HALF + 1.0), increasing=True)
)  # about the centre, (POINTS, POINTS)
FIRST = np.ascontiguousarray(MONOMIALS[1, HALF:])  # weights of u(+j) - u(-j) in the first derivative
SECOND = np.ascontiguousarray(2.0 * MONOMIALS[2, HALF:])  # of u(+j) + u(-j) in the second; [0] of u(0)
SCATTERED = 6  # points of the interpolant on unequal steps


@unfused_jit
def padded_samples(count: int) -> int:
    """Length of the array of `count` samples, HALF before and after them, whole packs."""
    return (count + WIDTH - 1) // WIDTH * WIDTH + 2 * HALF


@unfused_jit
def rates(samples: Array, h: float, velocity: Array, acceleration: Array) -> None:
    """First and second derivative at samples[HALF + i]; velocity, acceleration in whole packs."""
    for i in range(0, velocity.shape[0], WIDTH):
        v, a = splat(0.0), SECOND[0] * load(samples, i + HALF)
        for j in range(1, HALF + 1):
            ahead, behind = load(samples, i + HALF + j), load(samples, i + HALF - j)
            v = v + FIRST[j] * (ahead - behind)
            a = a + SECOND[j] * (ahead + behind)
        store(velocity, i, v * (1.0 / h))
        store(acceleration, i, a * (1.0 / (h * h)))


@unfused_jit
def hermite_peak(h: float, v0: float, v1: float, a0: float, a1: float) -> tuple[float, float]:
    """Largest v^2 and its place in [0, 1] of the cubic with these velocities and accelerations at its ends."""
    best, at = v0 * v0, 0.0
    if v1 * v1 > best:
        best, at = v1 * v1, 1.0
    c1, c2 = h * a0, 3.0 * (v1 - v0) - h * (2.0 * a0 + a1)
    c3 = 2.0 * (v0 - v1) + h * (a0 + a1)
    square = c2 * c2 - 3.0 * c3 * c1
    if square >= 0.0:
        q = -(c2 + math.copysign(math.sqrt(square), c2))
        for root in range(2):
            x = -1.0
            if root == 0 and c3 != 0.0:
                x = q / (3.0 * c3)
            if root == 1 and q != 0.0:
                x = c1 / q
            if 0.0 < x < 1.0:
                y = v0 + x * (c1 + x * (c2 + x * c3))
                if y * y > best:
                    best, at = y * y, x
    return best, at


@unfused_jit
def _derivative(c: Array, order: int, x: float) -> float:
    """Derivative of the monomial series c (POINTS,)."""
    s = 0.0
    for k in range(POINTS - 1, order - 1, -1):
        factor = 1.0
        for j in range(order):
            factor *= k - j
        s = s * x + factor * c[k]
    return s


@unfused_jit
def _polished(samples: Array, i: int, x: float, h: float, c: Array) -> tuple[float, float]:
    """v^2 and place of the stationary velocity near samples[HALF + i + x]: Newton on the interpolant; c (POINTS,)."""
    for k in range(POINTS):
        c[k] = 0.0
        for j in range(POINTS):
            c[k] += MONOMIALS[k, j] * samples[i + j]
    for _ in range(5):
        bend = _derivative(c, 3, x)
        if bend == 0.0:
            break
        x += min(0.25, max(-0.25, -_derivative(c, 2, x) / bend))
        x = min(1.2, max(-0.2, x))
    return (_derivative(c, 1, x) / h) ** 2, x


@unfused_jit
def sampled_peak(samples: Array, count: int, h: float, t_end: float) -> tuple[float, float]:
    """Largest v^2 on [0, t_end] and its time, from u at i h in samples[HALF + i], i < count; nan if one is not finite.

    Cubics find the candidates, the interpolant of POINTS samples polishes them.
    """
    velocity, acceleration = zeros(padded_samples(count) - 2 * HALF), zeros(padded_samples(count) - 2 * HALF)
    rates(samples, h, velocity, acceleration)
    rough, top, trouble = np.zeros(count), 0.0, 0.0
    for i in range(count - 1):
        v0, v1 = velocity[i], velocity[i + 1]
        trouble += v0 - v0  # nan as soon as one is not finite
        if max(v0 * v0, v1 * v1) >= 0.5 * top and i * h < t_end:
            rough[i], _ = hermite_peak(h, v0, v1, acceleration[i], acceleration[i + 1])
            top = max(top, rough[i])
    best, at, c = 0.0, 0.0, np.empty(POINTS)
    for i in range(count - 1):
        if rough[i] == 0.0 or rough[i] < 0.98 * top:
            continue
        _, x = hermite_peak(h, velocity[i], velocity[i + 1], acceleration[i], acceleration[i + 1])
        square, x = _polished(samples, i, x, h, c)
        if (i + x) * h > t_end:
            x = t_end / h - i
            square = (velocity[i] + x * h * acceleration[i]) ** 2
        if square > best:
            best, at = square, (i + x) * h
    return best + trouble, at


@unfused_jit
def _newton_form(t: Array, v: Array, first: int, origin: float, x: Array, c: Array) -> None:
    """Divided differences c (SCATTERED,) of the samples from `first` on, and their places x from the origin."""
    for j in range(SCATTERED):
        x[j], c[j] = t[first + j] - origin, v[first + j]
    for j in range(1, SCATTERED):
        for k in range(SCATTERED - 1, j - 1, -1):
            c[k] = (c[k] - c[k - 1]) / (x[k] - x[k - j])


@unfused_jit
def _scanned(x: Array, c: Array, lo: float, hi: float) -> tuple[float, float]:
    """Largest square of the polynomial in Newton form on [lo, hi] and its place, by three nested scans."""
    best, at = -1.0, lo
    for _ in range(3):
        width = (hi - lo) / 16.0
        for g in range(17):
            y = lo + width * g
            s = c[SCATTERED - 1]
            for k in range(SCATTERED - 2, -1, -1):
                s = s * (y - x[k]) + c[k]
            if s * s > best:
                best, at = s * s, y
        lo, hi = max(lo, at - width), min(hi, at + width)
    return best, at


@unfused_jit
def scattered_peak(t: Array, v: Array, count: int, t_end: float) -> tuple[float, float]:
    """Largest v^2 on [0, t_end] and its time, from the first `count` velocities v at times t, unequal steps."""
    best, at = 0.0, 0.0
    for i in range(count):
        if t[i] <= t_end and v[i] * v[i] > best:
            best, at = v[i] * v[i], t[i]
    if count < SCATTERED:
        return best, at
    x, c, enough = np.empty(SCATTERED), np.empty(SCATTERED), 0.9 * best
    for i in range(1, count - 1):
        square = v[i] * v[i]
        if square < enough or square < v[i - 1] ** 2 or square < v[i + 1] ** 2 or t[i - 1] > t_end:
            continue
        _newton_form(t, v, min(max(i - SCATTERED // 2, 0), count - SCATTERED), t[i], x, c)
        square, place = _scanned(x, c, t[i - 1] - t[i], min(t[i + 1], t_end) - t[i])
        if square > best:
            best, at = square, t[i] + place
    return best, at
