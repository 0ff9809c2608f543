"""The maximum of |velocity| over continuous time, from one quartic per step.

The maximum over solver output points misses up to 1e-4 of it even at rtol 1e-8; the quartic removes that error.
"""

import math

from kernel.jit import jit
from kernel.model import Array

ITERATIONS = 54  # of bisection they would reach machine precision
ENOUGH = 1e-9  # of a step: the last correction, the square of which is what is left


@jit
def _value(p: Array, x: float) -> float:
    return p[0] + x * (p[1] + x * (p[2] + x * (p[3] + x * p[4])))


@jit
def _slope(p: Array, x: float) -> float:
    return p[1] + x * (2.0 * p[2] + x * (3.0 * p[3] + x * 4.0 * p[4]))


@jit
def _bound(p: Array) -> float:
    """Largest Bernstein coefficient on [0, 1] in magnitude: |p| cannot exceed it there (convex hull)."""
    b1 = p[0] + p[1] / 4.0
    b2 = p[0] + p[1] / 2.0 + p[2] / 6.0
    b3 = p[0] + 0.75 * p[1] + p[2] / 2.0 + p[3] / 4.0
    b4 = p[0] + p[1] + p[2] + p[3] + p[4]
    return max(abs(p[0]), abs(b1), abs(b2), abs(b3), abs(b4))


@jit
def _root_of_slope(p: Array, lo: float, hi: float) -> float:
    """Where the slope, monotone and of opposite signs at lo and hi, is zero: Newton, bisecting where that leaves."""
    rising, x = _slope(p, lo) > 0.0, 0.5 * (lo + hi)
    for _ in range(ITERATIONS):
        slope, bend = _slope(p, x), 2.0 * p[2] + x * (6.0 * p[3] + x * 12.0 * p[4])
        if (slope > 0.0) == rising:
            lo = x
        else:
            hi = x
        new = x - slope / bend if bend != 0.0 else hi
        if abs(new - x) < ENOUGH:  # asked first: at the root x is an end of the interval, and new may be x
            return min(max(new, lo), hi)
        x = new if lo < new < hi else 0.5 * (lo + hi)
    return x


@jit
def _inflections(p: Array) -> tuple[float, float]:
    """The points of [0, 1] between which the slope is monotone, in order (1 where there is none)."""
    a, b, c = 12.0 * p[4], 6.0 * p[3], 2.0 * p[2]
    x0, x1 = 1.0, 1.0
    root = b * b - 4.0 * a * c
    if root > 0.0:
        q = -0.5 * (b + math.copysign(math.sqrt(root), b))
        if a != 0.0 and 0.0 < q / a < 1.0:
            x0 = q / a
        if q != 0.0 and 0.0 < c / q < 1.0:
            x1 = c / q
    return min(x0, x1), max(x0, x1)


@jit
def peak_of_quartic(p: Array, best: float) -> tuple[float, float]:
    """Largest |p(x)| on [0, 1] where it exceeds `best`, and its x; (best, -1) where it does not.

    `p` has shape (5,) or longer, constant term first.
    """
    at = -1.0
    if not _bound(p) > best:
        return best, at
    if abs(p[0]) > best:
        best, at = abs(p[0]), 0.0
    x0, x1 = _inflections(p)
    lo = 0.0
    for hi in (x0, x1, 1.0):
        candidates = (hi, _root_of_slope(p, lo, hi) if _slope(p, lo) * _slope(p, hi) < 0.0 else hi)
        for x in candidates:
            value = abs(_value(p, x))
            if value > best:
                best, at = value, x
        lo = hi
    return best, at
