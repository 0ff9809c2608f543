"""Where a quantity crosses a level along a line: which values of the axis are asked for next."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sweep.plan.fall import Array, Line, inside

FIRST, LAST = "first", "last"
START_MIN = 2  # values of the axis: between fewer nothing can be crossed


@dataclass(frozen=True)
class Crossing:
    """Which crossing of which level, the relative width of a narrow bracket, how many values a line may get at most."""

    level: float
    which: str
    until: float
    most: int


def wanted(line: Line, start: NDArray[np.int64], crossing: Crossing) -> list[int]:
    """Places whose rows must be known before the next step of the search, as of `sweep.plan.fall.wanted`."""
    if missing := [int(k) for k in start if not line.known[k]]:
        return missing
    line.asked[start] = True
    while np.count_nonzero(line.asked) < len(start) + crossing.most and (k := _next(line, crossing)) is not None:
        if not line.known[k]:
            return [k]
        line.asked[k] = True
    return []


def _next(line: Line, crossing: Crossing) -> int | None:
    places = np.flatnonzero(line.asked & np.isfinite(line.ratio))
    found = bracket(line.ratio[places], crossing.level, crossing.which)
    if found is None:
        return None
    return inside(line.N, line.asked, int(places[found]), int(places[found + 1]), crossing.until)


def bracket(values: Array, level: float, which: str) -> int | None:
    """The number of the value after which the level is crossed, up or down, for the first or the last time.

    A value that is the level itself lies above it. None where all lie on one side.
    """
    crossed = [k for k, (a, b) in enumerate(pairwise(values >= level)) if a != b]
    return (crossed[0] if which == FIRST else crossed[-1]) if crossed else None
