"""What a chain has that is not uniform: numbers of each site and link, an end without a wall, a driver that moves.

Dormand-Prince alone knows such chains (kernel.stages). A free end is a last link without stiffness and damper, a driven
first site one that no force moves: nothing else in the kernel asks for them.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.simd import WIDTH, zeros

Array = NDArray[np.float64]


class Motion(NamedTuple):
    """The velocity of a driver: straight pieces through `speeds` at `times`, and a sine that ends.

    In long-wave sound speeds and cell transit times of the uniform chain.
    """

    times: Array  # (k,) ascending from 0; after the last one the last speed stays
    speeds: Array  # (k,)
    amplitude: float
    omega: float
    until: float  # when the sine ends
    longest_step: float  # with which nothing of it is overlooked
    top: float  # largest speed
    holds: bool  # the first site moves so; else a driver does, which pushes it through the contact


class Varied(NamedTuple):
    """Numbers of every site i, at i - 1 of their row, and of the link to its right, over those of the uniform chain."""

    rows: Array  # (ROWS padded(N),), row after row, whole packs each
    motion: Motion


# Mass of each site; one over it, 0 behind the last site and of one that a driver holds; stiffness and damping of each
# link; 1 for the site that a driver holds, else 0.
MASS, LIGHTNESS, STIFFNESS, DAMPING, HELD, ROWS = range(6)
REST = Motion(np.zeros(1), np.zeros(1), 0.0, 0.0, 0.0, math.inf, 0.0, False)


def varied_of(mass: Array, stiffness: Array, damping: Array, free: bool, motion: Motion | None) -> Varied:
    """Of sites, links and dampers with these numbers, each (N,)."""
    N = len(mass)
    rows = zeros(ROWS * ((N + WIDTH - 1) // WIDTH * WIDTH)).reshape(ROWS, -1)
    rows[MASS] = 1.0
    for row, values in ((MASS, mass), (LIGHTNESS, 1.0 / mass), (STIFFNESS, stiffness), (DAMPING, damping)):
        rows[row, :N] = values
    if free:
        rows[[STIFFNESS, DAMPING], N - 1] = 0.0
    if motion is not None and motion.holds:
        rows[LIGHTNESS, 0], rows[HELD, 0] = 0.0, 1.0
    return Varied(rows.ravel(), REST if motion is None else motion)


@jit
def driven_acceleration(motion: Motion, t: float) -> float:
    """Of the driver at time t."""
    times, speeds = motion.times, motion.speeds
    a = motion.amplitude * motion.omega * math.cos(motion.omega * t) if t < motion.until else 0.0
    k = np.searchsorted(times, t, side="right")
    if 0 < k < len(times):
        a += (speeds[k] - speeds[k - 1]) / (times[k] - times[k - 1])
    return a


def along_chain(varied: Any, row: int, N: int) -> Array:
    """A number of all sites or links, (N,)."""
    return np.ones(N) if varied is None else np.asarray(varied.rows.reshape(ROWS, -1)[row, :N])


# A uniform chain has none of it: numba leaves out what is said of the others, as it compiles.
@jit
def own(varied: Any, row: int, i: int) -> float:
    """The number in this row of site, or of link, i = 1..N."""
    if varied is None:
        return 1.0
    return varied.rows[row * (varied.rows.shape[0] // ROWS) + i - 1]
