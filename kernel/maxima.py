"""The largest |velocity| over continuous time, from what is known of the velocity at the ends of steps.

The maximum over the steps' ends alone misses up to 1e-4 of it even at rtol 1e-8. Dormand-Prince knows the velocity
within a step as a quartic; the others know it and its slopes at both ends of a step (Hermite's polynomials).
"""

import math

from kernel.jit import jit
from kernel.model import Array

BISECTIONS = 54  # they would reach machine precision without Newton's method
# The last correction of a place, in steps: what is left of the value is its square.
QUARTIC_SETTLED, QUINTIC_SETTLED = 1e-9, 1e-7
NEWTON_STEPS = 8


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
    for _ in range(BISECTIONS):
        slope, bend = _slope(p, x), 2.0 * p[2] + x * (6.0 * p[3] + x * 12.0 * p[4])
        if (slope > 0.0) == rising:
            lo = x
        else:
            hi = x
        new = x - slope / bend if bend != 0.0 else hi
        if abs(new - x) < QUARTIC_SETTLED:  # asked first: at the root x is an end of the interval, and new may be x
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


@jit
def _extremum(p1: float, p2: float, p3: float, p4: float, p5: float, s: float) -> float:
    """Where the quintic with these coefficients of s, s^2, ... is extremal in [0, 1]: Newton from s, with bisection."""
    low, high = 0.0, 1.0
    for _ in range(NEWTON_STEPS):
        slope = p1 + s * (2.0 * p2 + s * (3.0 * p3 + s * (4.0 * p4 + s * 5.0 * p5)))
        if slope * p1 > 0.0:
            low = s
        else:
            high = s
        bend = 2.0 * p2 + s * (6.0 * p3 + s * (12.0 * p4 + s * 20.0 * p5))
        new = s - slope / bend if bend != 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - s) < QUINTIC_SETTLED:
            break
        s = new
    return s


@jit
def quintic_crest(
    h: float, v0: float, v1: float, a0: float, a1: float, jerk0: float, jerk1: float
) -> tuple[float, float]:
    """Largest |v| in a step of size h by the quintic Hermite polynomial, and where, as a fraction of the step."""
    best, where = (abs(v1), 1.0) if abs(v1) > abs(v0) else (abs(v0), 0.0)
    if a0 * a1 >= 0.0:
        return best, where
    p1, p2 = h * a0, 0.5 * h * h * jerk0
    r0, r1, r2 = v1 - v0 - p1 - p2, h * a1 - p1 - 2.0 * p2, h * h * jerk1 - 2.0 * p2
    p3, p4, p5 = 10.0 * r0 - 4.0 * r1 + 0.5 * r2, -15.0 * r0 + 7.0 * r1 - r2, 6.0 * r0 - 3.0 * r1 + 0.5 * r2
    s = _extremum(p1, p2, p3, p4, p5, a0 / (a0 - a1))
    x = abs(v0 + s * (p1 + s * (p2 + s * (p3 + s * (p4 + s * p5)))))
    return (x, s) if x > best else (best, where)


@jit
def cubic_crest(h: float, v0: float, v1: float, a0: float, a1: float) -> tuple[float, float]:
    """Largest |v| in a step of size h by the cubic Hermite polynomial, and where, as a fraction of the step."""
    best, where = (abs(v1), 1.0) if abs(v1) > abs(v0) else (abs(v0), 0.0)
    if a0 * a1 >= 0.0:
        return best, where
    p1, p2, p3 = h * a0, 3.0 * (v1 - v0) - h * (2.0 * a0 + a1), -2.0 * (v1 - v0) + h * (a0 + a1)
    q = -(p2 + math.copysign(math.sqrt(max(0.0, p2 * p2 - 3.0 * p3 * p1)), p2))  # both roots without cancellation
    for s in (q / (3.0 * p3) if p3 != 0.0 else -1.0, p1 / q if q != 0.0 else -1.0):
        x = abs(v0 + s * (p1 + s * (p2 + s * p3)))
        if 0.0 < s < 1.0 and x > best:
            best, where = x, s
    return best, where


@jit
def cubic_at(s: float, h: float, v0: float, v1: float, a0: float, a1: float) -> float:
    """The cubic Hermite polynomial where a fraction s of a step of size h is over."""
    p1, p2, p3 = h * a0, 3.0 * (v1 - v0) - h * (2.0 * a0 + a1), -2.0 * (v1 - v0) + h * (a0 + a1)
    return v0 + s * (p1 + s * (p2 + s * p3))
