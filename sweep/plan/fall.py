"""Which N an adaptive sweep asks for next: a pure function of one line's values, a line being one impact and zeta_T.

analysis.transition, which reads the table afterwards, has the same HIGH, LOW, RIPPLE and means the same by a fall.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

HIGH, LOW = 1.0, 0.7  # ke_ratio: a transition falls from above HIGH to below LOW, and stays there
RIPPLE = 1.1  # a rise by less than this factor does not end the fall
START_MIN = 3  # values of N to start from: analysis.transition takes no line of fewer
LOG_SLOPE = "log_slope"  # to find: where log ke_ratio falls most; "level" is only where ke_ratio last crosses HIGH

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Rule:
    """What to find, the relative width at which a bracket is narrow enough, and how many N a line may get at most."""

    find: str
    until: float
    most: int


def lattice(start: Sequence[Any], until: float, whole: bool = True) -> list[Any]:
    """Every value that may be asked for, ascending: `start`, halved in log N until neighbours are within `until`.

    Between 0 and the next value there is none. Other values than `whole` numbers are rounded to 12 digits, as those of
    a grid: all machines must get the same tasks.
    """
    ends = sorted(start)
    values = ends[:1]
    for a, b in pairwise(ends):
        values += [*_between(a, b, until, whole), b]
    return values


def _between(a: Any, b: Any, until: float, whole: bool) -> list[Any]:
    root = float(np.sqrt(float(a) * float(b)))
    middle = round(root) if whole else float(f"{root:.12g}")
    if b <= (1.0 + until) * a or not a < middle < b:
        return []
    return [*_between(a, middle, until, whole), middle, *_between(middle, b, until, whole)]


@dataclass(frozen=True)
class Line:
    """One line over the whole lattice, each of shape (n,)."""

    N: Array  # or the values of another axis
    ratio: Array  # or another quantity; nan where the row is chaotic, failed or not known
    known: Mask
    asked: Mask  # the search's own path: only these are looked at, whatever else is known


def wanted(line: Line, start: NDArray[np.int64], rule: Rule) -> list[int]:
    """Places on the lattice whose rows must be known before the next step of the search; none where it is over.

    `line.asked` is carried on from one call to the next, at first all false. The search waits for every value that it
    asks for, so that only the values decide, not the order in which they arrive.
    """
    if missing := [int(k) for k in start if not line.known[k]]:
        return missing
    line.asked[start] = True
    line = replace(line, ratio=np.where(line.ratio > 0, line.ratio, np.nan))  # logarithms follow
    while np.count_nonzero(line.asked) < len(start) + rule.most and (k := _next(line, rule)) is not None:
        if not line.known[k]:
            return [k]
        line.asked[k] = True
    return []


def _next(line: Line, rule: Rule) -> int | None:
    asked = line.asked
    places = np.flatnonzero(asked & np.isfinite(line.ratio)).tolist()
    ratio = line.ratio[places]
    if not places:
        return None
    if not ratio[-1] < LOW:  # the N beyond may be chaotic: find out up to where values exist
        beyond = np.flatnonzero(asked[places[-1] + 1 :])
        return inside(line.N, asked, places[-1], places[-1] + 1 + int(beyond[0]), rule.until) if len(beyond) else None
    high = np.flatnonzero(ratio[:-1] > HIGH)
    if not len(high):
        return None
    last = int(high[-1])
    k = inside(line.N, asked, places[last], places[last + 1], rule.until)
    return _in_fall(line, places, last) if k is None and rule.find == LOG_SLOPE else k


def inside(N: Array, asked: Mask, i: int, j: int, until: float) -> int | None:
    """The next N to ask for between two; None where they are near enough, or nothing in between has a value.

    What was asked for in between has none (chaotic or failed): approach it from either end.
    """
    if N[j] <= (1.0 + until) * N[i]:
        return None
    stops = [i, *(i + 1 + np.flatnonzero(asked[i + 1 : j])).tolist(), j]
    for a, b in ((i, stops[1]), (stops[-2], j)):
        if N[b] > (1.0 + until) * N[a] and b - a > 1:
            return (a + b) // 2
    return None


def _in_fall(line: Line, places: list[int], last: int) -> int | None:
    """The N that halves the interval of the steepest slope, as if all its drop lay between two neighbours there."""
    log_N, log_ratio = np.log(line.N), np.log(line.ratio[places])
    steepest, chosen = -np.inf, None
    for q in _fall(line.ratio[places], last):
        i, j = places[q], places[q + 1]
        k = inside(line.N, line.asked, i, j, 0.0)
        narrowest = log_N[j] - log_N[i] if k is None else np.diff(log_N[i : j + 1]).min()
        if (slope := (log_ratio[q] - log_ratio[q + 1]) / narrowest) > steepest:
            steepest, chosen = slope, k
    return chosen


def _fall(ratio: Array, last: int) -> range:
    """The intervals of the fall through HIGH; `last` is the number of the last value above HIGH."""
    first = end = last
    while first > 0 and ratio[first - 1] * RIPPLE > ratio[first]:
        first -= 1
    while end < len(ratio) - 1 and ratio[end + 1] < RIPPLE * ratio[end]:
        end += 1
    return range(first, max(end, first + 1))
