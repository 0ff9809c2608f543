"""Which N an adaptive sweep asks for next: a pure function of one line's values, a line being one impact and zeta_T.

analysis.transition, which reads the table afterwards, has HIGH, LOW and the fall from here.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from sweep.plan.axis import rounded
from sweep.plan.line import Line

HIGH, LOW = 1.0, 0.7  # ke_ratio: a transition falls from above HIGH to below LOW, and stays there
RIPPLE = 1.1  # a rise by less than this factor does not end the fall
START_MIN = 3  # values of N to start from: analysis.transition takes no line of fewer
LOG_SLOPE = "log_slope"  # to find: where log ke_ratio falls most; "level" is only where ke_ratio last crosses HIGH


@dataclass(frozen=True)
class Rule:
    """What to find, the relative width at which a bracket is narrow enough, and how many N a line may get at most."""

    find: str
    until: float
    most: int

    def following(self, line: Line) -> int | None:
        """The next place of the line's path, by the places so far; None where the path ends."""
        places, ratio = line.places, line.numbers
        if not places:
            return None
        if not ratio[-1] < LOW:  # the N beyond may be chaotic: find out up to where values exist
            beyond = line.asked_after(places[-1])
            return None if beyond is None else line.inside(places[-1], beyond, self.until)
        last = last_high(ratio)
        if last is None:
            return None
        k = line.inside(places[last], places[last + 1], self.until)
        return _in_fall(line, last) if k is None and self.find == LOG_SLOPE else k


def lattice(start: Sequence[Any], until: float, whole: bool = True) -> list[Any]:
    """Every value that may be asked for, ascending: `start`, halved in log N until neighbours are within `until`.

    Between 0 and the next value there is none. Negative values are halved as their amounts are, and what lies between a
    negative and a positive one evenly, until neighbours are within `until` of the larger amount. Other values than
    `whole` numbers are rounded, as those of a grid.
    """
    ends = sorted(start)
    values = ends[:1]
    for a, b in pairwise(ends):
        values += [*_inside(a, b, until, whole), b]
    return values


def _inside(a: Any, b: Any, until: float, whole: bool) -> list[Any]:
    if a >= 0:
        return _between(a, b, until, whole)
    if b <= 0:
        return [-value for value in reversed(_between(-b, -a, until, whole))]
    return _evenly(a, b, until * max(-a, b))


def _evenly(a: float, b: float, width: float) -> list[float]:
    values = [a, b]
    while np.diff(values).max() > width:  # all parts are halved or none: rounding makes some of equal ones a bit wider
        values = sorted(values + [rounded(0.5 * (left + right)) for left, right in pairwise(values)])
    return values[1:-1]


def _between(a: Any, b: Any, until: float, whole: bool) -> list[Any]:
    root = float(np.sqrt(float(a) * float(b)))
    middle = round(root) if whole else rounded(root)
    if b <= (1.0 + until) * a or not a < middle < b:
        return []
    return [*_between(a, middle, until, whole), middle, *_between(middle, b, until, whole)]


def _in_fall(line: Line, last: int) -> int | None:
    """The N that halves the interval of the steepest slope, as if all its drop lay between two neighbours there."""
    places, slopes, steepest, chosen = line.places, line.slopes, -np.inf, None
    for q in fall(line.numbers, last):
        ends = places[q], places[q + 1]
        if ends not in slopes:
            slopes[ends] = _slope(line, q)
        slope, k = slopes[ends]
        if slope > steepest:
            steepest, chosen = slope, k
    return chosen


def _slope(line: Line, q: int) -> tuple[float, int | None]:
    """How steep it can be behind the number `q` of a line, and the place that halves this interval."""
    (i, j), logs = line.places[q : q + 2], line.axis.logs
    k = line.inside(i, j, 0.0)
    above, below = np.log(line.numbers[q : q + 2]).tolist()
    return (above - below) / (logs[j] - logs[i] if k is None else line.axis.narrowest(i, j)), k


def last_high(ratio: Sequence[float]) -> int | None:
    """The number of the last value above HIGH that has one after it; None where there is none."""
    return next((q for q in range(len(ratio) - 2, -1, -1) if ratio[q] > HIGH), None)


def fall(ratio: Sequence[float], last: int) -> range:
    """The intervals of the last fall through HIGH; `last` is what `last_high` gives.

    Elsewhere nobody looks: in short chains ke_ratio jumps as steeply there.
    """
    first = end = last
    while first > 0 and ratio[first - 1] * RIPPLE > ratio[first]:
        first -= 1
    while end < len(ratio) - 1 and ratio[end + 1] < RIPPLE * ratio[end]:
        end += 1
    return range(first, max(end, first + 1))
