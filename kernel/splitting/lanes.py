"""One tridiagonal system in 16 lanes: the chain is cut into 16 segments of `rows` consecutive sites.

Site i is in row (i-1) % rows + 1 of lane (i-1) // rows, at 16 row + lane of a flat array; rows 0 and rows + 1 are
halos, room for the neighbours of other lanes. The matrix is 1 + q S, S the negative second difference (free left end,
wall at the right): LU factorised, its two recurrences run in all lanes at once as if nothing came from the neighbouring
lane; what came is then added exactly, as a carry times the product of the weights it passes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.model import Array
from kernel.simd import WIDEST, left_neighbours, load_sixteen, right_neighbours, splat_as, store, zeros

LANES = WIDEST
WEIGHT_MIN = 1e-19  # a carry with less weight does not pass through a lane


class Lanes(NamedTuple):
    """The factors of the matrix, (16 (rows + 2),) each, and the solution under way."""

    rows: int
    forward: Array  # weight of the left neighbour in the forward recurrence
    backward: Array  # weight of the right neighbour in the backward recurrence
    pivot: Array  # one over the pivots
    from_left: Array  # weight of the carry from the left lane: product of `forward` from the lane's first row
    from_right: Array  # weight of the carry from the right lane
    column: Array  # first column of the inverse: what a unit impulse on site 1 does
    x: Array
    carry: Array  # (16,)
    places: NDArray[np.int64]  # (N + 1,): where site or link i = 1..N lies, looked up faster than by `place`


@jit
def rows_of(N: int) -> int:
    """Rows for N sites."""
    return (N + LANES - 1) // LANES


@jit
def place(i: int, rows: int) -> int:
    """Where site or link i = 1..16 rows lies."""
    return LANES * ((i - 1) % rows + 1) + (i - 1) // rows


@jit
def place_after(k: int, rows: int) -> int:
    """Where the next site or link lies: found faster than by `place`, which divides."""
    after = k + LANES
    return after if after < LANES * (rows + 1) else LANES + k % LANES + 1


@jit
def place_before(k: int, rows: int) -> int:
    """Where the one before lies."""
    return k - LANES if k >= 2 * LANES else LANES * rows + k - LANES - 1


@jit
def new_row(N: int) -> Array:
    """Zeros for N sites and the halos."""
    return zeros(LANES * (rows_of(N) + 2))


@jit
def new_lanes(N: int) -> Lanes:
    """Room for the factors of N sites."""
    places, k = np.zeros(N + 1, np.int64), LANES
    for i in range(1, N + 1):
        places[i] = k
        k = place_after(k, rows_of(N))
    return Lanes(
        rows_of(N),
        new_row(N),
        new_row(N),
        new_row(N),
        new_row(N),
        new_row(N),
        new_row(N),
        new_row(N),
        zeros(LANES),
        places,
    )


@jit
def _eliminate(N: int, lanes: Lanes, q: float) -> None:
    """LU without pivoting, which a diagonally dominant matrix does not need; sites beyond N stay zero."""
    diagonal, before, k = 1.0 + q, 0.0, LANES
    for i in range(1, N + 1):
        pivot = 1.0 / diagonal
        lanes.forward[k], lanes.pivot[k] = before, pivot
        before = q * pivot
        lanes.backward[k] = before if i < N else 0.0
        diagonal = 1.0 + 2.0 * q - q * before
        k = place_after(k, lanes.rows)


@jit
def factor(N: int, lanes: Lanes, q: float) -> bool:
    """Factorise 1 + q S for N sites; whether a carry reaches beyond the next lane."""
    rows, last_row = lanes.rows, LANES * lanes.rows
    _eliminate(N, lanes, q)
    largest, y, k = 0.0, 1.0, LANES
    for i in range(1, N + 1):
        lanes.from_left[k] = lanes.forward[k] * (lanes.from_left[k - LANES] if k >= 2 * LANES else 1.0)
        y = lanes.forward[k] * y if i > 1 else 1.0
        lanes.column[k] = y
        if k >= last_row:
            largest = max(largest, lanes.from_left[k])
        k = place_after(k, rows)
    y, k = 0.0, place(N, rows)
    for _ in range(N):
        lanes.from_right[k] = lanes.backward[k] * (lanes.from_right[k + LANES] if k < last_row else 1.0)
        y = lanes.column[k] * lanes.pivot[k] + lanes.backward[k] * y
        lanes.column[k] = y
        if k < 2 * LANES:
            largest = max(largest, lanes.from_right[k])
        k = place_before(k, rows)
    return largest > WEIGHT_MIN


@jit
def eliminate_right(
    x: Array, carry: Array, v: Array, g: Array, weight: Array, from_left: Array, rows: int, far: bool
) -> None:
    """x = v + (g - g left) + weight * (x left), every lane by itself; then carry[l] = last x of
    lane l - 1, its own carry included."""
    left = load_sixteen(g, 0)
    y = splat_as(0.0, left)
    for k in range(LANES, (rows + 1) * LANES, LANES):
        here = load_sixteen(g, k)
        y = load_sixteen(weight, k) * y + (load_sixteen(v, k) + (here - left))
        store(x, k, y)
        left = here
    store(carry, 0, left_neighbours(splat_as(0.0, y), y))
    if far:
        last = rows * LANES
        for lane in range(1, LANES - 1):
            carry[lane + 1] += from_left[last + lane] * carry[lane]


@jit
def substitute_left(
    x: Array,
    carry: Array,
    pivot: Array,
    weight: Array,
    from_left: Array,
    from_right: Array,
    rows: int,
    far: bool,
) -> float:
    """x <- pivot * (x + from_left carry) + weight * (x right), every lane by itself; then carry[l] = first x of
    lane l + 1, its own carry included. Returns x at site 1, likewise.
    """
    c = load_sixteen(carry, 0)
    y = splat_as(0.0, c)
    for k in range(rows * LANES, 0, -LANES):
        known = load_sixteen(from_left, k) * c + load_sixteen(x, k)
        y = load_sixteen(weight, k) * y + load_sixteen(pivot, k) * known
        store(x, k, y)
    store(carry, 0, right_neighbours(y, splat_as(0.0, y)))
    if far:
        for lane in range(LANES - 2, 0, -1):
            carry[lane - 1] += from_right[LANES + lane] * carry[lane]
    return x[LANES] + from_right[LANES] * carry[0]


@jit
def solve(lanes: Lanes, v: Array, g: Array, far: bool) -> float:
    """Solve (1 + q S) x = v + g - (g left) but for what `add_up` adds; x at site 1.

    v, g: (16 (rows + 2),); row 0 of g holds the g of the left neighbours. far: as `factor` said.
    """
    eliminate_right(lanes.x, lanes.carry, v, g, lanes.forward, lanes.from_left, lanes.rows, far)
    return substitute_left(
        lanes.x, lanes.carry, lanes.pivot, lanes.backward, lanes.from_left, lanes.from_right, lanes.rows, far
    )


@jit
def add_up(v: Array, x: Array, carry: Array, from_right: Array, column: Array, impulse: float, rows: int) -> None:
    """v = the solution, and what an impulse on site 1 adds to it."""
    c = load_sixteen(carry, 0)
    for k in range(LANES, (rows + 1) * LANES, LANES):
        own = load_sixteen(from_right, k) * c + load_sixteen(x, k)
        store(v, k, impulse * load_sixteen(column, k) + own)
