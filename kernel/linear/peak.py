"""The maximum of the squared velocity over continuous time, from samples of the middle site on unequal steps."""

import numpy as np

from kernel.jit import unfused_jit
from kernel.model import Array

SCATTERED = 6  # points of the interpolant


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
