"""A sweep that asks for more as results arrive. Its table has a row for every N that may be asked for.

So a task's number and its row follow from the spec, as in any grid, and which of them are computed from the values
alone: neither depends on ranks, order or kills.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.plan.fall import Line, Rule, lattice, wanted
from sweep.plan.tasks import Ids, Tasks
from sweep.schema import DONE


def most_asked(shape: tuple[int, int], start: int, rule: Rule) -> int:
    """How many tasks a search of `shape` (N that may be asked for, lines) from `start` N on each line can become."""
    return shape[1] * min(shape[0], start + rule.most)


def every_task(grid: Mapping[str, Sequence[Any]], until: float | None) -> Tasks:
    """All that have a row: the grid, with every N that a search which narrows brackets to `until` may ask for."""
    return Tasks(grid if until is None else {**grid, "N": lattice(grid["N"], until)})


class Search:
    """What is known of every line (one impact and zeta_T), and what is to be computed next."""

    def __init__(self, grid: Mapping[str, Sequence[Any]], rule: Rule) -> None:
        """`grid`: the axes as the user wrote them; its N are where every line starts."""
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
        """So many tasks it can become."""
        return most_asked(self._shape, len(self._start), self._rule)

    def learn(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Take in finished rows. Chaotic and failed ones tell nothing, and are not asked for again."""
        where = np.unravel_index(ids, self._shape)
        tells = (rows["status"] == DONE) & ~rows["chaotic"] & (rows["ke_ratio"] > 0) & np.isfinite(rows["ke_ratio"])
        self._known[where] = True
        self._ratio[where] = np.where(tells, rows["ke_ratio"], np.nan)

    def wanted(self) -> Ids:
        """What is missing now, on all lines."""
        return self._wanted(range(self._shape[1]))

    def more(self, ids: Ids, rows: NDArray[np.void]) -> Ids:
        """Take in rows; what is missing now on their lines, but for what this has told before."""
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


def more_of(
    search: Search | None, predicted: Callable[[Ids], NDArray[np.float64]]
) -> Callable[[Ids, NDArray[np.void]], tuple[Ids, NDArray[np.float64]]] | None:
    """For the master: what finished rows lead to, with its predicted seconds."""
    if search is None:
        return None

    def more(ids: Ids, rows: NDArray[np.void]) -> tuple[Ids, NDArray[np.float64]]:
        return (new := search.more(ids, rows)), predicted(new)

    return more
