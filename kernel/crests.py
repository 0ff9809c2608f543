"""How fast the middle site ever was in each part of a run: what the peak is compared with, and what nearly wins.

Also the disturbance of the start by which a run is compared with itself.

An answer is no surer than the second highest crest allows: where a late, chaotic one comes close to the peak, another
run may take it for the peak.
"""

import numpy as np

from kernel.jit import jit
from kernel.model import Array

PARTS = 16  # of a run, equally long


@jit
def new_crests() -> Array:
    """Nothing seen yet, (PARTS,)."""
    return np.zeros(PARTS)


@jit
def part_of(t: float, t_end: float) -> int:
    """The part of the run in which t lies."""
    return min(PARTS - 1, int(t / t_end * PARTS))


@jit
def disturb(v: Array, N: int, size: float) -> None:
    """Add random velocities, even from -size to size and always the same, to v[:N]."""
    x = 1
    for i in range(N):
        x = 48271 * x % 2147483647  # Park and Miller's generator
        v[i] += size * (2.0 * x / 2147483647.0 - 1.0)
