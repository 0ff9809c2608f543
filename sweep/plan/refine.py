"""A search for a map: in every plane of some axes more is computed until the rest can be interpolated.

Every plane is computed in rounds. What a round asks for follows from the numbers of the rounds before it alone, in
whatever order they came and whatever else is known; planes do not wait for each other.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sweep.plan.lowest import blocks
from sweep.plan.search import usable
from sweep.plan.spline import Array, coordinates, first_places, wanted
from sweep.plan.tasks import Ids, Tasks

ROUND = 0.01  # share of a plane's places; larger rounds take a few more tasks, smaller ones leave more ranks waiting


class Planes:
    """Which task of a grid lies where on which plane, and the numbers there."""

    def __init__(self, tasks: Tasks, over: Sequence[str]) -> None:
        axes = [tasks.axes[name].tolist() for name in tasks.axes if name in over]
        self.shape = tuple(map(len, axes))
        self.at = coordinates(axes)  # (places, axes)
        self.ids = blocks(tasks, over, 1)[:, :, 0]  # (planes, places)
        self.logs = np.full(len(tasks), np.nan)

    def tell(self, ids: Ids, numbers: Array) -> None:
        """Numbers of these tasks, nan where they are worth nothing; so are those that have no logarithm."""
        with np.errstate(invalid="ignore", divide="ignore"):
            logs = np.log(numbers)
        self.logs[ids] = np.where(np.isfinite(logs), logs, np.nan)


class Refine:
    """Which places of every plane were asked for, and which tasks its round waits for."""

    screens = 0.0

    def __init__(self, tasks: Tasks, over: Sequence[str], of: str, error: float, share: float) -> None:
        """`over`: the axes of a plane, ascending; `error`: of the logarithm, that interpolation is to keep.

        share: of a plane's places, that one round asks for.
        """
        self.tasks, self.of, self._error, self._planes = tasks, of, error, Planes(tasks, over)
        planes, places = self._planes.ids.shape
        self._most = max(1, round(share * places))  # places of a round
        self._asked = np.zeros((planes, places), np.bool_)  # in this round of the plane or one before
        self._asked[:, first_places(self._planes.shape)] = True
        self._plane = np.empty(len(tasks), np.int64)  # of every task
        self._plane[self._planes.ids] = np.arange(planes)[:, None]
        self._known, self._out = np.zeros((2, len(tasks)), np.bool_)
        self._waits = np.zeros(planes, np.int64)  # tasks given out for a plane that are not known
        self._over = np.zeros(planes, np.bool_)
        self._changed = np.arange(planes)

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Chaotic and failed rows give no number, and are not asked for again."""
        self._planes.tell(ids, usable(rows, self.of))
        np.subtract.at(self._waits, self._plane[ids], self._out[ids] & ~self._known[ids])
        self._known[ids] = True
        self._changed = np.append(self._changed, self._plane[ids])

    def tell_seen(self, orders: Ids, values: Array) -> None:
        """Nothing is ever screened."""

    def ask(self) -> Ids:
        """The next round of every plane that has all numbers of its last one."""
        changed, self._changed = np.unique(self._changed), self._changed[:0]
        ready = changed[(self._waits[changed] == 0) & ~self._over[changed]]
        return np.sort(np.concatenate([np.empty(0, np.int64), *map(self._next, ready.tolist())]))

    def _next(self, plane: int) -> Ids:
        ids, asked, at = self._planes.ids[plane], self._asked[plane], self._planes.at
        while not len(missing := ids[asked & ~self._known[ids]]):
            places = wanted(at, self._planes.logs[ids], asked, self._error, self._most)
            if not len(places):
                self._over[plane] = True
                break
            asked[places] = True
        self._out[missing] = True
        self._waits[plane] = len(missing)
        return np.asarray(missing, np.int64)
