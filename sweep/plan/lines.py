"""A search along lines: one axis is refined, on each line by itself, a line being one combination of the other axes."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.plan.fall import Line, lattice
from sweep.plan.search import Along, Extent, usable
from sweep.plan.tasks import Ids, Tasks

Rule = Callable[[Line, NDArray[np.int64]], list[int]]  # the places that are missing next, of a line and its start


def with_lattice(grid: Mapping[str, Sequence[Any]], axis: str, until: float) -> dict[str, Sequence[Any]]:
    """The axes of all tasks that may be asked for: of `axis` every value, down to the relative width `until`."""
    return {**grid, axis: lattice(grid[axis], until, whole=axis == "N")}


def extent(grid: Mapping[str, Sequence[Any]], axis: str, until: float, most: int) -> Extent:
    """How much a search along lines computes that adds at most `most` tasks to each."""
    lines, start = math.prod(len(values) for name, values in grid.items() if name != axis), len(grid[axis])
    places = len(with_lattice(grid, axis, until)[axis])
    return Extent(lines * start, lines * min(places, start + most), 0)


class Lines:
    """What is known of every line, and which of its tasks are computed next."""

    screens = False

    def __init__(
        self, grid: Mapping[str, Sequence[Any]], axis: str, until: float, rule: Rule, of: str = "ke_ratio"
    ) -> None:
        """`grid`: the axes as the user wrote them; every line starts with the values of `axis` that it has there."""
        self.tasks, self._rule, self.of = Tasks(with_lattice(grid, axis, until)), rule, of
        values, self._along = self.tasks.axes[axis], Along(self.tasks, axis)
        self._values = values.astype(np.float64)
        self._start = np.searchsorted(values, sorted(grid[axis]))
        shape = len(values), self._along.lines
        self._number = np.full(shape, np.nan)
        self._known, self._asked, self._out = (np.zeros(shape, np.bool_) for _ in range(3))
        self._changed = set(range(self._along.lines))

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Chaotic and failed rows give no value, and are not asked for again."""
        where = self._along.where(ids)
        self._known[where] = True
        self._number[where] = usable(rows, self.of)
        self._changed.update(where[1].tolist())

    def tell_screened(self, ids: Ids, values: NDArray[np.float64]) -> None:
        """Nothing is ever screened."""

    def ask(self) -> Ids:
        """What is missing now on the lines that have changed."""
        changed, self._changed = sorted(self._changed), set()
        return np.sort(np.concatenate([np.empty(0, np.int64), *map(self._missing, changed)]))

    def _missing(self, number: int) -> Ids:
        line = Line(self._values, self._number[:, number], self._known[:, number], self._asked[:, number])
        places = [k for k in self._rule(line, self._start) if not self._out[k, number]]
        self._out[places, number] = True
        return self._along.ids(np.array(places, np.int64), number)
