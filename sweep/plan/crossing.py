"""Where a quantity crosses a level along a line: which values of the axis are asked for next."""

from collections.abc import Sequence
from dataclasses import dataclass

from sweep.plan.line import Line

FIRST, LAST = "first", "last"
START_MIN = 2  # values of the axis: between fewer nothing can be crossed


@dataclass(frozen=True)
class Crossing:
    """Which crossing of which level, the relative width of a narrow bracket, how many values a line may get at most."""

    level: float
    which: str
    until: float
    most: int

    def following(self, line: Line) -> int | None:
        """The next place of the line's path, by the places so far; None where the path ends."""
        found = bracket(line.numbers, self.level, self.which)
        return None if found is None else line.inside(line.places[found], line.places[found + 1], self.until)


def bracket(values: Sequence[float], level: float, which: str) -> int | None:
    """The number of the value after which the level is crossed, up or down, for the first or the last time.

    A value that is the level itself lies above it. None where all lie on one side.
    """
    places = range(len(values) - 1)
    for k in places if which == FIRST else reversed(places):
        if (values[k] >= level) != (values[k + 1] >= level):
            return k
    return None
