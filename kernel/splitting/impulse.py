"""The implicit contact: one equation for the overlap at a step's end, by Newton's method.

The contact force of a step is the discrete gradient of the Hertz energy E(d) = (2/5) K d^(5/2),
    F = (E(d1) - E(d0)) / (d1 - d0),
so that the work it does is exactly the contact energy given back: no step size makes a contact gain energy.
"""

import math

from kernel.jit import jit

ITERATIONS = 40
ENOUGH = 1e-10  # relative, of the root of the overlap; Newton's method squares the error


@jit
def contact_impulse(d0: float, d_free: float, K: float, softness: float) -> tuple[float, float]:
    """Overlap d1 at the end of a step and the force F with d1 = d_free - softness F.

    d0: overlap at the start; d_free: at the end if there were no contact; negative: a gap.
    """
    if d0 <= 0.0 and d_free <= 0.0:
        return d_free, 0.0
    c, root = 0.4 * K * softness, math.sqrt(max(d0, 0.0))
    if d0 > 0.0 and c * root * root * root >= d_free:
        return _leave(root, d_free, c, softness)
    top = math.sqrt(d_free)
    b = root if d0 > 0.0 else top
    for _ in range(ITERATIONS):
        f, slope = _stay(root, b, d_free, c) if d0 > 0.0 else _arrive(-d0, b, d_free, c)
        new = b - f / slope
        if new <= 0.0:  # not min and max, which would hide a nan
            new = 0.5 * b
        if new > top:
            new = top
        done = abs(new - b) <= ENOUGH * new
        b = new
        if done:
            break
    return b * b, (d_free - b * b) / softness


@jit
def _leave(root: float, d_free: float, c: float, softness: float) -> tuple[float, float]:
    """The contact opens: E(d1) = 0 leaves a quadratic for d1 <= 0, solved without cancellation."""
    p, r = 0.5 * (root * root + d_free), root * root * (c * root * root * root - d_free)
    d1 = -r / (p + math.sqrt(p * p + r)) if p > 0.0 else p - math.sqrt(p * p + r)
    return d1, (d_free - d1) / softness


@jit
def _arrive(gap: float, b: float, d_free: float, c: float) -> tuple[float, float]:
    """d1 - d_free + softness F and its derivative, in b = sqrt(d1), from a gap: E(d0) = 0."""
    share, b4 = b * b + gap, b * b * b * b
    return b * b - d_free + c * b * b4 / share, 2.0 * b + c * (5.0 * b4 - 2.0 * b * b * b4 / share) / share


@jit
def _stay(a: float, b: float, d_free: float, c: float) -> tuple[float, float]:
    """The same from an overlap a^2: (b^5 - a^5) / (b^2 - a^2) with the common factor b - a taken out."""
    share = a + b
    quartic = a * a * a * a + b * (a * a * a + b * (a * a + b * (a + b)))
    slope = a * a * a + b * (2.0 * a * a + b * (3.0 * a + 4.0 * b))
    return b * b - d_free + c * quartic / share, 2.0 * b + c * (slope - quartic / share) / share
