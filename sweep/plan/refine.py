"""A search for a map: in every plane of some axes the boxes are halved until the rest can be interpolated."""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sweep.plan.lowest import blocks
from sweep.plan.mesh import Box, corners, first_boxes, halfway, halves, is_done, scale_of
from sweep.plan.search import usable
from sweep.plan.tasks import Ids, Tasks


class Opened(NamedTuple):
    """A box of one plane."""

    plane: int
    box: Box


class Planes:
    """Which task of a grid lies where on which plane, and the numbers there."""

    def __init__(self, tasks: Tasks, over: Sequence[str]) -> None:
        names = [name for name in tasks.axes if name in over]
        self.shape = tuple(len(tasks.axes[name]) for name in names)
        self.scales = [scale_of(tasks.axes[name].tolist()) for name in names]
        self.ids = blocks(tasks, over, 1)[:, :, 0].reshape(-1, *self.shape)
        self.logs = np.full(len(tasks), np.nan)

    def tell(self, ids: Ids, numbers: NDArray[np.float64]) -> None:
        """Numbers of these tasks, nan where they are worth nothing; so are those that have no logarithm."""
        with np.errstate(invalid="ignore", divide="ignore"):
            logs = np.log(numbers)
        self.logs[ids] = np.where(np.isfinite(logs), logs, np.nan)

    def log(self, plane: int, place: tuple[int, ...]) -> float:
        """The logarithm at a place."""
        return float(self.logs[self.ids[(plane, *place)]])


class Refine:
    """Which boxes are looked at, and which tasks they wait for."""

    screens = False

    def __init__(self, tasks: Tasks, over: Sequence[str], of: str, error: float) -> None:
        """`over`: the axes of a plane, ascending; `error`: of the logarithm, that interpolation is to keep."""
        self.tasks, self.of, self._error, self._planes = tasks, of, error, Planes(tasks, over)
        self._known, self._out = np.zeros((2, len(tasks)), np.bool_)
        first = first_boxes(self._planes.shape)
        self._open = [Opened(plane, box) for plane in range(len(self._planes.ids)) for box in first]
        self._waiting: dict[int, list[Opened]] = defaultdict(list)  # by the task that a box lacks

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Chaotic and failed rows give no number, and are not asked for again."""
        self._planes.tell(ids, usable(rows, self.of))
        self._known[ids] = True
        for task in ids.tolist():
            self._open += self._waiting.pop(task, [])

    def tell_seen(self, orders: Ids, values: NDArray[np.float64]) -> None:
        """Nothing is ever screened."""

    def ask(self) -> Ids:
        """What the boxes lack that can be looked at now."""
        new = set[int]()
        while self._open:
            opened = self._open.pop()
            if missing := self._missing(opened):
                self._waiting[missing[0]].append(opened)
                new.update(task for task in missing if not self._out[task])
            else:
                self._open += self._parts(opened)
        self._out[list(new)] = True
        return np.array(sorted(new), np.int64)

    def _missing(self, opened: Opened) -> list[int]:
        places = (*corners(opened.box), *halfway(opened.box))
        tasks = [int(self._planes.ids[(opened.plane, *place)]) for place in places]
        return [task for task in tasks if not self._known[task]]

    def _parts(self, opened: Opened) -> list[Opened]:
        """The boxes that are looked at after a box all of whose places are known."""
        plane, box = opened
        parts, planes = halves(box), self._planes
        if len(parts) == 1 or is_done(box, planes.scales, lambda place: planes.log(plane, place), self._error):
            return []
        return [Opened(plane, part) for part in parts]
