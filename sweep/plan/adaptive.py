"""An adaptive sweep: finished rows decide which tasks are computed next.

Its table has a row for every N that may be asked for. So a task's number follows from the spec, as in any grid, and
which tasks are computed follows from the values of rows: neither depends on ranks, on their order, or on kills.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.plan.fall import Line, Rule, lattice, wanted
from sweep.plan.tasks import Ids, Tasks
from sweep.schema import DONE


def most_asked(shape: tuple[int, int], start: int, rule: Rule) -> int:
    """How many tasks a search computes at most; `shape`: number of N that may be asked for, number of lines."""
    return shape[1] * min(shape[0], start + rule.most)


def every_task(grid: Mapping[str, Sequence[Any]], until: float | None) -> Tasks:
    """All tasks that have a row: the grid, and of a search every N that it may ask for to reach the width `until`."""
    return Tasks(grid if until is None else {**grid, "N": lattice(grid["N"], until)})


class Search:
    """What is known of every line (one impact and one zeta_T, all N), and which of its tasks are computed next."""

    def __init__(self, grid: Mapping[str, Sequence[Any]], rule: Rule) -> None:
        """`grid`: the axes as the user wrote them; every line starts with the N of the grid."""
        self.tasks, self._rule = every_task(grid, rule.until), rule
        N = self.tasks.axes["N"]
        self._N = N.astype(np.float64)
        self._start = np.searchsorted(N, sorted(grid["N"]))
        self._shape = len(N), len(self.tasks) // len(N)
        self._ratio = np.full(self._shape, np.nan)
        self._known, self._asked, self._out = (np.zeros(self._shape, np.bool_) for _ in range(3))

    @property
    def first(self) -> Ids:
        """The tasks that every search begins with."""
        return self._ids(self._start, np.arange(self._shape[1]))

    @property
    def at_most(self) -> int:
        """How many tasks the search computes at most."""
        return most_asked(self._shape, len(self._start), self._rule)

    def learn(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Take in finished rows. Chaotic and failed ones give no value, and are not asked for again."""
        where = np.unravel_index(ids, self._shape)
        valid = (rows["status"] == DONE) & ~rows["chaotic"] & (rows["ke_ratio"] > 0) & np.isfinite(rows["ke_ratio"])
        self._known[where] = True
        self._ratio[where] = np.where(valid, rows["ke_ratio"], np.nan)

    def wanted(self) -> Ids:
        """The tasks that are missing now, on all lines."""
        return self._wanted(range(self._shape[1]))

    def more(self, ids: Ids, rows: NDArray[np.void]) -> Ids:
        """Take in rows; the tasks that are missing now on their lines, without those already handed out."""
        self.learn(ids, rows)
        return self._wanted(np.unique(ids % self._shape[1]).tolist())

    def _wanted(self, lines: Sequence[int]) -> Ids:
        ids = [np.empty(0, np.int64)]
        for number in lines:
            line = Line(self._N, self._ratio[:, number], self._known[:, number], self._asked[:, number])
            places = [k for k in wanted(line, self._start, self._rule) if not self._out[k, number]]
            self._out[places, number] = True
            ids.append(self._ids(np.array(places, np.int64), np.array([number])))
        return np.sort(np.concatenate(ids))

    def _ids(self, places: NDArray[Any], lines: NDArray[Any]) -> Ids:
        ids: Ids = np.add.outer(places * self._shape[1], lines).ravel()
        return ids
