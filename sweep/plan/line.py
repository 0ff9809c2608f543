"""What is known of one line of a search along lines, kept as it grows: a line is asked tens of times what comes next.

Plain numbers in lists: of the few that a line has, numpy would spend its time on looking at what it was given.
"""

from bisect import bisect_right, insort
from collections.abc import Sequence
from functools import cached_property
from math import inf, isfinite

import numpy as np


class Axis:
    """The values that may be asked for, ascending; one for all lines."""

    def __init__(self, values: Sequence[float]) -> None:
        self.values = [float(value) for value in values]
        self._narrowest = dict[tuple[int, int], float]()

    @cached_property
    def logs(self) -> list[float]:
        """Their logarithms, which only some searches need."""
        return [float(log) for log in np.log(self.values)]

    def narrowest(self, i: int, j: int) -> float:
        """The smallest step of the logarithm between two places."""
        if (i, j) not in self._narrowest:
            self._narrowest[i, j] = min(b - a for a, b in zip(self.logs[i:j], self.logs[i + 1 : j + 1], strict=True))
        return self._narrowest[i, j]

    def is_narrow(self, i: int, j: int, until: float) -> bool:
        """Whether two values are as near as is asked for, relative to the one nearer to zero."""
        low, high = self.values[i], self.values[j]
        if low < 0.0:
            return -low <= (1.0 + until) * -high  # never across zero
        return high <= (1.0 + until) * low


class Line:
    """One line over the whole axis. Places are numbers of values on it."""

    def __init__(self, axis: Axis, above: float = -inf) -> None:
        """`above`: only numbers above this tell something."""
        self.axis, self._above = axis, above
        self.known = dict[int, float]()  # nan where the row is chaotic or failed
        self.asked = list[int]()  # the search's own path, ascending: only these are looked at, whatever else is known
        self.places, self.numbers = list[int](), list[float]()  # those of them that tell something

        self.slopes = dict[tuple[int, int], tuple[float, int | None]]()  # of `sweep.plan.fall`, as long as they hold

    def look_at(self, place: int) -> None:
        """Take a known place into the path."""
        insort(self.asked, place)
        self.slopes.pop(self._around(place), None)
        number = self.known[place]
        if isfinite(number) and number > self._above:
            at = bisect_right(self.places, place)
            self.places.insert(at, place)
            self.numbers.insert(at, number)

    def _around(self, place: int) -> tuple[int, int]:
        """The places that tell something before and after one."""
        at = bisect_right(self.places, place)
        return (self.places[at - 1], self.places[at]) if 0 < at < len(self.places) else (place, place)

    def asked_after(self, place: int) -> int | None:
        """The next place of the path."""
        at = bisect_right(self.asked, place)
        return self.asked[at] if at < len(self.asked) else None

    def inside(self, i: int, j: int, until: float) -> int | None:
        """The next place to ask for between two; None where they are near enough, or nothing in between has a number.

        What was asked for in between has none (chaotic or failed): approach it from either end.
        """
        if self.axis.is_narrow(i, j, until):
            return None
        first, last = bisect_right(self.asked, i), bisect_right(self.asked, j - 1)
        between = self.asked[first:last]
        for a, b in ((i, between[0]), (between[-1], j)) if between else ((i, j),):
            if b - a > 1 and not self.axis.is_narrow(a, b, until):
                return (a + b) // 2
        return None
