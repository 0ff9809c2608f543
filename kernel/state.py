"""The state of a chain as Dormand-Prince steps from it: both ends of a step and the accelerations of its stages."""

from typing import NamedTuple

import numpy as np

from kernel import tableau
from kernel.jit import jit
from kernel.model import Array
from kernel.simd import WIDTH, zeros

LAST = tableau.STAGES - 1


class State(NamedTuple):
    """The chain at both ends of a step: half `now` (0 or 1) is its start, the other half its end.

    Arrays of sites are padded with zeros, the wall. Where the next step begins, the halves change their roles, and so
    do the first and the last row of accelerations (first same as last): nothing is copied.
    """

    u: Array  # (2 padded(N),) displacements, site i at i - 1 of its half
    v: Array  # (2 padded(N),) velocities
    k: Array  # (7 padded(N),) accelerations of the stages, row after row
    impactor: Array  # (4,): u_0, v_0 of half 0, of half 1
    k_impactor: Array  # (7,)
    inside: Array  # (8,): 1 for the sites of the last pack that are before the wall, else 0


@jit
def padded(N: int) -> int:
    """Length of a row of sites: whole packs."""
    return (N + WIDTH - 1) // WIDTH * WIDTH


@jit
def new_state(N: int, speed: float) -> State:
    """Everything at rest and unstrained but the impactor."""
    n = padded(N)
    impactor, inside = np.zeros(4), zeros(WIDTH)
    impactor[1] = speed
    inside[: N - (n - WIDTH)] = 1.0
    return State(zeros(2 * n), zeros(2 * n), zeros(tableau.STAGES * n), impactor, np.zeros(tableau.STAGES), inside)


@jit
def row(stage: int, now: int) -> int:
    """Which row of accelerations belongs to a stage."""
    return LAST - stage if now == 1 and stage in (0, LAST) else stage
