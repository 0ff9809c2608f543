"""One tridiagonal system in 16 lanes: the chain is cut into 16 segments of `rows` consecutive sites.

Site i is in row (i-1) % rows + 1 of lane (i-1) // rows, at 16 row + lane of a flat array; rows 0 and rows + 1 are
halos, room for the neighbours of other lanes. The matrix is 1 + q S, S the negative second difference (free left end,
wall at the right): LU factorised, its two recurrences run in all lanes at once as if nothing came from the neighbouring
lane; what came is then added exactly, as a carry times the product of the weights it passes. Weak dampers let a carry
through few rows: the others are left as they are. All is done in place, as what a step takes is memory by and large.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.model import Array
from kernel.simd import WIDEST, left_neighbours, load_sixteen, right_neighbours, splat_as, store, zeros

LANES = WIDEST
WEIGHT_MIN = 1e-19  # a carry is added to the rows where it has more weight than this part of itself


class Lanes(NamedTuple):
    """The factors of the matrix, (16 (rows + 2),) each, and what lanes carry to their neighbours."""

    pivot: Array  # one over the pivots
    weight: Array  # of a neighbour in the recurrences: q over the pivots
    from_left: Array  # weight of the carry from the left lane: product of `weight` from the lane's first row
    from_right: Array  # weight of the carry from the right lane
    column: Array  # first column of the inverse: what a unit impulse on site 1 does
    carry: Array  # (16,)
    places: NDArray[np.int64]  # (N + 1,): where site or link i = 1..N lies


@jit
def rows_of(N: int) -> int:
    """Rows for N sites."""
    return (N + LANES - 1) // LANES


@jit
def place_after(k: int, rows: int) -> int:
    """Where the next site or link lies."""
    after = k + LANES
    return after if after < LANES * (rows + 1) else LANES + k % LANES + 1


@jit
def new_row(N: int) -> Array:
    """Zeros for N sites and the halos."""
    return zeros(LANES * (rows_of(N) + 2))


@jit
def new_lanes(N: int) -> Lanes:
    """Room for the factors of up to N sites: how many is for `number` to say."""
    factors = new_row(N), new_row(N), new_row(N), new_row(N), new_row(N)
    return Lanes(*factors, zeros(LANES), np.zeros(N + 1, np.int64))


@jit
def number(lanes: Lanes, n: int) -> None:
    """Let the room hold the first n sites alone: the places of the others lead to row 0, where all is zero."""
    lanes.pivot[:] = lanes.weight[:] = 0.0
    lanes.places[:] = 0
    k = LANES
    for i in range(1, n + 1):
        lanes.places[i] = k
        k = place_after(k, rows_of(n))


@jit
def lay_out(x: Array, n: int, rows: int, more_rows: int) -> None:
    """Move the numbers of n sites from so many rows to more; zeros follow."""
    here, there, old = LANES, LANES, x.copy()
    x[:] = 0.0
    for _ in range(n):
        x[there] = old[here]
        here, there = place_after(here, rows), place_after(there, more_rows)


@jit
def _eliminate(N: int, lanes: Lanes, q: float) -> None:
    """LU without pivoting, which a diagonally dominant matrix does not need; sites beyond N stay zero."""
    diagonal, pivot, settled, k, left, rows = 1.0 + q, 1.0, 0.0, LANES, N, rows_of(N)
    while left > 0 and diagonal != settled:
        pivot, settled = 1.0 / diagonal, diagonal
        lanes.pivot[k], lanes.weight[k] = pivot, q * pivot
        diagonal = 1.0 + 2.0 * q - q * q * pivot
        k = place_after(k, rows)
        left -= 1
    for _ in range(left):  # from some site on all are alike
        lanes.pivot[k], lanes.weight[k] = pivot, q * pivot
        k = place_after(k, rows)


@jit
def reach_of(q: float) -> int:
    """How many sites a carry reaches, and with it what a step does to a site."""
    far_weight = 2.0 * q / (1.0 + 2.0 * q + math.sqrt(1.0 + 4.0 * q))  # far from the ends
    return 1 + int(math.log(WEIGHT_MIN) / math.log(max(WEIGHT_MIN, far_weight)))


@jit
def factor(N: int, lanes: Lanes, q: float) -> int:
    """Factorise 1 + q S for N sites; the rows that a carry reaches, all of them where it reaches beyond a lane."""
    pivot, weight, from_left, from_right, column, carry, _ = lanes
    rows = rows_of(N)
    _eliminate(N, lanes, q)
    right = splat_as(1.0, load_sixteen(carry, 0))
    zero = right - right
    left, first_lane = right, left_neighbours(right, zero)
    for k in range(LANES, (rows + 1) * LANES, LANES):
        store(from_left, k, left)
        store(column, k, first_lane * left)
        left = load_sixteen(weight, k) * left
    for k in range(rows * LANES, 0, -LANES):
        right = load_sixteen(weight, k) * right
        store(from_right, k, right)
    reach = min(rows, reach_of(q))
    carry_right(carry, weight, from_left, load_sixteen(column, rows * LANES), zero, rows, reach)
    substitute_left(column, carry, pivot, weight, from_left, from_right, rows, reach)
    add_up(column, carry, from_right, column, 0.0, rows, reach)
    return reach


@jit
def carry_right(carry: Array, weight: Array, from_left: Array, last: Any, impulse: Any, rows: int, reach: int) -> None:
    """carry[l] = what comes to the first site of lane l from lane l - 1, its own carry included.

    last, impulse: every lane's forward recurrence by itself at its last site, and the impulse of that site's link.
    """
    store(carry, 0, left_neighbours(splat_as(0.0, last), load_sixteen(weight, rows * LANES) * last - impulse))
    if reach == rows:
        for k in range(rows * LANES + 1, (rows + 1) * LANES - 1):
            lane = k - rows * LANES
            carry[lane + 1] += weight[k] * from_left[k] * carry[lane]


@jit
def substitute_left(
    x: Array, carry: Array, pivot: Array, weight: Array, from_left: Array, from_right: Array, rows: int, reach: int
) -> float:
    """x <- pivot * (x + from_left carry) + weight * (x right), every lane by itself; then carry[l] = first x of
    lane l + 1, its own carry included. Returns x at site 1, likewise.
    """
    c = load_sixteen(carry, 0)
    y = splat_as(0.0, c)
    for k in range(rows * LANES, reach * LANES, -LANES):
        y = load_sixteen(weight, k) * y + load_sixteen(pivot, k) * load_sixteen(x, k)
        store(x, k, y)
    for k in range(reach * LANES, 0, -LANES):
        known = load_sixteen(from_left, k) * c + load_sixteen(x, k)
        y = load_sixteen(weight, k) * y + load_sixteen(pivot, k) * known
        store(x, k, y)
    store(carry, 0, right_neighbours(y, splat_as(0.0, y)))
    if reach == rows:
        for lane in range(LANES - 2, 0, -1):
            carry[lane - 1] += from_right[LANES + lane] * carry[lane]
    return x[LANES] + from_right[LANES] * carry[0]


@jit
def add_up(x: Array, carry: Array, from_right: Array, column: Array, impulse: float, rows: int, reach: int) -> None:
    """Add to the solution what the lanes to the right carry, and what an impulse on site 1 does."""
    c = load_sixteen(carry, 0)
    if 2 * reach > rows:
        for k in range(LANES, (rows + 1) * LANES, LANES):
            own = load_sixteen(from_right, k) * c + load_sixteen(x, k)
            store(x, k, impulse * load_sixteen(column, k) + own)
        return
    for k in range(LANES, (reach + 1) * LANES, LANES):
        store(x, k, impulse * load_sixteen(column, k) + load_sixteen(x, k))
    for k in range((rows - reach + 1) * LANES, (rows + 1) * LANES, LANES):
        store(x, k, load_sixteen(from_right, k) * c + load_sixteen(x, k))
