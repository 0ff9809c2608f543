"""A search along lines: one axis is refined, on each line by itself, a line being one combination of the other axes."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.plan import fall
from sweep.plan.crossing import Crossing
from sweep.plan.line import Axis, Line
from sweep.plan.search import Along, Extent, Search, usable
from sweep.plan.tasks import Ids, Tasks

Rule = fall.Rule | Crossing  # what is looked for on every line


def wanted(line: Line, start: Sequence[int], rule: Rule) -> list[int]:
    """Places on the lattice whose rows must be known before the next step of the search; none where it is over.

    `line.asked` is carried on from one call to the next, at first empty. The search waits for every value that it asks
    for, so that only the values decide, not the order in which they arrive.
    """
    if not line.asked:
        if missing := [place for place in start if place not in line.known]:
            return missing
        for place in start:
            line.look_at(place)
    while len(line.asked) < len(start) + rule.most and (k := rule.following(line)) is not None:
        if k not in line.known:
            return [k]
        line.look_at(k)
    return []


def with_lattice(grid: Mapping[str, Sequence[Any]], axis: str, until: float) -> dict[str, Sequence[Any]]:
    """The axes of all tasks that may be asked for: of `axis` every value, down to the relative width `until`."""
    return {**grid, axis: fall.lattice(grid[axis], until, whole=axis == "N")}


def extent(grid: Mapping[str, Sequence[Any]], axis: str, rule: Rule) -> Extent:
    """How much a search along lines computes."""
    lines, start = math.prod(len(values) for name, values in grid.items() if name != axis), len(grid[axis])
    places = len(with_lattice(grid, axis, rule.until)[axis])
    return Extent(lines * start, lines * min(places, start + rule.most))


class Lines(Search):
    """What is known of every line, and which of its tasks are computed next."""

    def __init__(
        self,
        grid: Mapping[str, Sequence[Any]],
        axis: str,
        rule: Rule,
        of: str = "ke_ratio",
        above: float = -math.inf,
    ) -> None:
        """`grid`: the axes as the user wrote them; every line starts with the values of `axis` that it has there.

        above: only numbers above this tell something.
        """
        self.tasks, self._rule, self.of = Tasks(with_lattice(grid, axis, rule.until)), rule, of
        values, self._along = self.tasks.axes[axis], Along(self.tasks, axis)
        self._start = np.searchsorted(values, sorted(grid[axis])).tolist()
        one = Axis(values.tolist())
        self._lines = [Line(one, above) for _ in range(self._along.lines)]
        self._out = [set[int]() for _ in self._lines]
        self._changed = set(range(self._along.lines))

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Chaotic and failed rows give no value, and are not asked for again."""
        places, numbers = (array.tolist() for array in self._along.where(ids))
        for place, number, value in zip(places, numbers, usable(rows, self.of).tolist(), strict=True):
            self._lines[number].known[place] = value
        self._changed.update(numbers)

    def ask(self) -> Ids:
        """What is missing now on the lines that have changed."""
        changed, self._changed = self._changed, set()
        places, numbers = list[int](), list[int]()
        for number in changed:
            out = self._out[number]
            new = [k for k in wanted(self._lines[number], self._start, self._rule) if k not in out]
            out.update(new)
            places += new
            numbers += [number] * len(new)
        return np.sort(self._along.ids(np.array(places, np.int64), np.array(numbers, np.int64)))
