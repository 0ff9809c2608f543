"""The largest speed within one step, from what is known of the velocity at its two ends."""

import math

from kernel.jit import jit
from kernel.model import Array, Chain, tension

ITERATIONS = 8
ENOUGH = 1e-7  # of a step: moves the value of a maximum by its square


@jit
def pull(chain: Chain, e: Array, v: Array, i: int) -> float:
    """Force of link i, spring and damper, in the layout of kernel.splitting.sweeps."""
    return tension(chain.spring, e[i]) + 2.0 * chain.zeta * (v[i + 1] - v[i])


@jit
def acceleration(chain: Chain, e: Array, v: Array, i: int) -> float:
    """Acceleration of site i without contact at it."""
    return pull(chain, e, v, i) - (pull(chain, e, v, i - 1) if i > 1 else 0.0)


@jit
def acceleration_and_jerk(chain: Chain, e: Array, v: Array, i: int) -> tuple[float, float]:
    """Acceleration of site i >= 3 and its derivative, without contact at it and its neighbours."""
    g0, g1 = pull(chain, e, v, i - 2), pull(chain, e, v, i - 1)
    g2, g3 = pull(chain, e, v, i), pull(chain, e, v, i + 1)
    a = g2 - g1
    k1, k2 = chain.spring.stiffness_at(e[i - 1]), chain.spring.stiffness_at(e[i])
    springs = k2 * (v[i + 1] - v[i]) - k1 * (v[i] - v[i - 1])
    return a, springs + 2.0 * chain.zeta * ((g3 - g2) - 2.0 * a + (g1 - g0))


@jit
def _extremum(p1: float, p2: float, p3: float, p4: float, p5: float, s: float) -> float:
    """Where the quintic with these coefficients of s, s^2, ... is extremal in [0, 1]: Newton from s, with bisection."""
    low, high = 0.0, 1.0
    for _ in range(ITERATIONS):
        slope = p1 + s * (2.0 * p2 + s * (3.0 * p3 + s * (4.0 * p4 + s * 5.0 * p5)))
        if slope * p1 > 0.0:
            low = s
        else:
            high = s
        bend = 2.0 * p2 + s * (6.0 * p3 + s * (12.0 * p4 + s * 20.0 * p5))
        new = s - slope / bend if bend != 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - s) < ENOUGH:
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
