"""How the crests of two runs differ: the largest kinetic energies of the middle site in each part of a run."""

import numpy as np

from kernel.jit import jit
from kernel.model import Array
from kernel.watch import PARTS


@jit
def _before(x: Array, p: int) -> int:
    """The part before p that has a crest, or the first. Steps longer than parts leave some without one, 0."""
    k = p - 1
    while k > 0 and x[k] == 0.0:
        k -= 1
    return max(k, 0)


@jit
def _after(x: Array, p: int) -> int:
    """The part after p that has a crest, or the last."""
    k = p + 1
    while k < PARTS - 1 and x[k] == 0.0:
        k += 1
    return min(k, PARTS - 1)


@jit
def _nearest(x: Array, y: Array, p: int) -> float:
    """Least difference of x[p], and y[p] or a neighbour of it: a crest may pass into the next part of the run."""
    before, after = y[_before(y, p)], y[_after(y, p)]
    return float(min(abs(x[p] - y[p]), abs(x[p] - before), abs(x[p] - after)))


@jit
def moved(here: Array, there: Array, margin: float) -> float:
    """Relative change of the largest KE of `here` (PARTS,) if each crest changes as much as from here to `there`.

    Another crest than the largest may change `margin` times as much. Never less than the largest has changed.
    """
    top, other = 0, 0.0
    for p in range(PARTS):
        if here[p] > here[top]:
            top = p
        other = max(other, there[p])
    most = abs(here[top] - other)
    for p in range(PARTS):
        change = _nearest(here, there, p)
        if p == top:
            most = max(most, change)
        elif here[p] >= here[_before(here, p)] and here[p] >= here[_after(here, p)]:  # a crest of its own
            most = max(most, here[p] + margin * change - here[top])
    return most / here[top]


@jit
def wins_late(crests: Array, t_end_over_N: float, nearly: float) -> bool:
    """Whether a crest that comes later than sound crosses the chain is the largest, or above this share of it."""
    first = int(PARTS / t_end_over_N)
    return bool(first < PARTS and np.max(crests[first:]) > nearly * np.max(crests))
