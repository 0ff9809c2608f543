"""Packed sweeps over the sites of one chain in natural order, eight at a time, or sixteen in single precision.

State: e[i] is the strain of link i = 1..N, e[0] the gap between impactor and first site; v[i] is the velocity of site
i = 1..N, v[0] the impactor's. Both are rows (see `row`): site 1 begins a cache line, and whatever lies beyond site N is
zero, as is the wall's velocity v[N+1].

A drift moves the strains with the velocities held, a kick the velocities with the strains held. `mask` (16,) is one for
those sites of the sweep's last pack that are part of the chain and zero for those beyond its end.
"""

from typing import Any

import numpy as np

from kernel.jit import jit
from kernel.model import Array, Chain, tension
from kernel.simd import (
    WIDEST,
    element,
    greatest,
    larger,
    least,
    left_neighbours,
    load,
    right_neighbours,
    smaller,
    splat_as,
    store,
    width,
    zeros,
)

Pack = Any  # eight doubles or sixteen singles
SPARE = 4  # packs of zeros beyond the last site, for those that reach over the end


@jit
def row(n: int, one: Any) -> Array:
    """Zeros for the impactor and n sites, as precise as `one`; site 1 begins a cache line, for cheap loads."""
    raw = zeros(n + WIDEST * (1 + SPARE), one)
    return raw[width(raw) - 1 :]


@jit
def end_mask(N: int, one: Any) -> Array:
    """(16,): 1 for the sites of the last pack that belong to a chain of N sites, else 0; as precise as `one`."""
    mask = zeros(WIDEST, one)
    for i in range((N - 1) % width(mask) + 1):
        mask[i] = 1.0
    return mask


@jit
def _last(v: Array, n: int) -> int:
    """Where the last pack of sites 1..n begins."""
    return (n - 1) // width(v) * width(v) + 1


@jit
def _tension(chain: Chain, e: Array, i: int, dv: Pack, drift_h: float, rate: Pack) -> Pack:
    """Drift a pack of links by dv over drift_h; their tension, the dampers at `rate`."""
    x = drift_h * dv + load(e, i)
    store(e, i, x)
    return chain.spring.excess(x) + (2.0 * chain.zeta * rate + x)


@jit
def drift(e: Array, v: Array, n: int, h: float) -> None:
    """Drift links 1..n over h."""
    here = load(v, 1)
    for i in range(1, _last(v, n) + 1, width(v)):
        after = load(v, i + width(v))
        store(e, i, h * (right_neighbours(here, after) - here) + load(e, i))
        here = after


@jit
def kick(chain: Chain, e: Array, v: Array, n: int, drift_h: float, h: float, mask: Array) -> None:
    """Drift links 1..n over drift_h, then kick sites 1..n over h, the dampers at the velocities before (Euler)."""
    last = _last(v, n)
    left, here = splat_as(0.0, load(v, 1)), load(v, 1)
    for i in range(1, last, width(v)):
        after = load(v, i + width(v))
        dv = right_neighbours(here, after) - here
        g = _tension(chain, e, i, dv, drift_h, dv)
        store(v, i, h * (g - left_neighbours(left, g)) + here)
        left, here = g, after
    dv = right_neighbours(here, splat_as(0.0, here)) - here
    g = _tension(chain, e, last, dv, drift_h, dv)
    store(v, last, (h * (g - left_neighbours(left, g)) + here) * load(mask, 0))


@jit
def accelerate(chain: Chain, e: Array, v: Array, a: Array, n: int, drift_h: float, mask: Array) -> None:
    """Drift links 1..n over drift_h; a, a row: accelerations of sites 1..n without contact."""
    last = _last(v, n)
    left, here = splat_as(0.0, load(v, 1)), load(v, 1)
    for i in range(1, last, width(v)):
        after = load(v, i + width(v))
        dv = right_neighbours(here, after) - here
        g = _tension(chain, e, i, dv, drift_h, dv)
        store(a, i, g - left_neighbours(left, g))
        left, here = g, after
    dv = right_neighbours(here, splat_as(0.0, here)) - here
    g = _tension(chain, e, last, dv, drift_h, dv)
    store(a, last, (g - left_neighbours(left, g)) * load(mask, 0))


@jit
def pull(chain: Chain, e: Array, v: Array, i: int) -> float:
    """Force of link i, spring and damper."""
    return tension(chain.spring, np.float64(e[i])) + 2.0 * chain.zeta * (v[i + 1] - v[i])


@jit
def acceleration(chain: Chain, e: Array, v: Array, i: int) -> float:
    """Acceleration of site i without contact at it."""
    return pull(chain, e, v, i) - (pull(chain, e, v, i - 1) if i > 1 else 0.0)


@jit
def acceleration_and_jerk(chain: Chain, e: Array, v: Array, i: int) -> tuple[float, float]:
    """Acceleration of site i and its derivative, without contact."""
    z = 2.0 * chain.zeta
    g = pull(chain, e, v, i)
    after = pull(chain, e, v, i + 1) if i < chain.N else g  # the wall does not move
    jerk = chain.spring.stiffness_at(np.float64(e[i])) * (v[i + 1] - v[i])
    if i == 1:
        return g, jerk + z * (after - 2.0 * g)
    a, a_left = g - pull(chain, e, v, i - 1), acceleration(chain, e, v, i - 1)
    jerk -= chain.spring.stiffness_at(np.float64(e[i - 1])) * (v[i] - v[i - 1])
    return a, jerk + z * ((after - g) - 2.0 * a + a_left)


@jit
def _second_difference(left: Pack, x: Pack, right: Pack) -> Pack:
    return (right_neighbours(x, right) - x) - (x - left_neighbours(left, x))


@jit
def spread(v: Array, a: Array, n: int, c0: float, c1: float, c2: float, mask: Array) -> None:
    """v += (c0 + c1 S + c2 S S) a on sites 1..n; S: second difference, free left end, wall at the right.

    One pass: S a is kept for the pack before, this one and the next.
    """
    keep, x, last = load(mask, 0), load(a, 1), _last(v, n)
    zero = splat_as(0.0, x)
    right = load(a, 1 + width(v)) if last > 1 else zero
    s = _second_difference(splat_as(element(x, 0), x), x, right)
    if last == 1:
        s = s * keep
    s_before = splat_as(element(s, 0), s)  # free end: the site left of the first moves as the first
    for i in range(1, last, width(v)):
        far = load(a, i + 2 * width(v)) if i + width(v) < last else zero
        s_right = _second_difference(x, right, far)
        if i + width(v) == last:
            s_right = s_right * keep
        store(v, i, c2 * _second_difference(s_before, s, s_right) + (c1 * s + (c0 * x + load(v, i))))
        x, right, s_before, s = right, far, s, s_right
    more = c2 * _second_difference(s_before, s, zero) + (c1 * s + (c0 * x + load(v, last)))
    store(v, last, more * keep)


@jit
def strains(chain: Chain, e: Array, n: int) -> tuple[float, float]:
    """Smallest strain of links 1..n, 0 at most, and the largest, 0 at least, where the stiffness depends on it."""
    low = high = splat_as(0.0, load(e, 1))
    for i in range(1, n + 1, width(e)):
        low = smaller(load(e, i), low)
        if chain.spring.stiffens_in_tension():
            high = larger(load(e, i), high)
    return least(low), greatest(high)
