"""A search for a map: in every plane of some axes more is computed until the rest can be inferred.

Every task is screened first, unless that is switched off. Then what is interpolated is not the logarithm of the number,
but by how much that lies above the logarithm of what screening gave: cliffs and peaks that both show alike are no hill
between computed places. Each plane is computed in rounds. The first takes a lattice; the second, where tasks were
screened, what lies spread over the places that screening shows rough, where it is most often off; the others follow
from what the computed places show.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sweep.plan.lowest import blocks
from sweep.plan.rounds import Rounds
from sweep.plan.search import SCREEN, usable
from sweep.plan.spline import Array, coordinates, first_places, interpolated, rough_places, wanted
from sweep.plan.tasks import Ids, Tasks

ROUND = 0.03  # share of a plane's places; larger rounds take a few more tasks, smaller ones leave more ranks waiting


class Planes:
    """Which task of a grid lies where on which plane."""

    def __init__(self, tasks: Tasks, over: Sequence[str]) -> None:
        axes = [tasks.axes[name].tolist() for name in tasks.axes if name in over]
        self.shape = tuple(map(len, axes))
        self.at = coordinates(axes)  # (places, axes)
        self.ids = blocks(tasks, over, 1)[:, :, 0]  # (planes, places)

    def inferred(self, numbers: Array, seen: Array, computed: NDArray[np.bool_]) -> Array:
        """The logarithm of every task's number (n,), from those that are computed; nan where they tell nothing.

        numbers: nan where they are worth nothing; seen: what screening gave, 1 where nothing is screened.
        """
        above, found = logs_above(numbers, seen), np.empty(len(numbers))
        for ids in self.ids:
            found[ids] = interpolated(self.at, above[ids], computed[ids])
        return found + logs_above(seen, np.ones(len(seen)))


def logs_above(numbers: Array, seen: Array) -> Array:
    """By how much the logarithm of numbers lies above that of what screening gave; nan where either has none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        above = np.log(numbers) - np.log(seen)
    return np.where(np.isfinite(above), above, np.nan)


class Refine(Rounds):
    """What is known of every plane, and which of its places its rounds have asked for."""

    def __init__(
        self, tasks: Tasks, over: Sequence[str], of: str, error: float, share: float = ROUND, screen: bool = True
    ) -> None:
        """`over`: the axes of a plane, ascending; `error`: of the logarithm, that inference is to keep.

        share: of a plane's places, that one round asks for; screen: whether all tasks are screened first.
        """
        import scipy.spatial  # noqa: F401  before any rank waits for what it is needed for

        self.of, self._error, self._planes = of, error, Planes(tasks, over)
        super().__init__(tasks, self._planes.ids)
        self.screens = math.inf if screen else 0.0
        planes, places = self._planes.ids.shape
        self._most = max(1, round(share * places))  # places of a round
        self._asked = np.zeros((planes, places), np.bool_)  # to compute
        self._asked[:, first_places(self._planes.shape)] = True
        self._first = np.full(planes, screen)  # whether screening has still to tell where it is rough
        self._number, self._seen = np.full(len(tasks), np.nan), np.ones(len(tasks))

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Chaotic and failed rows give no number, and are not asked for again."""
        self._number[ids] = usable(rows, self.of)
        self.learn(ids)

    def tell_seen(self, orders: Ids, values: Array) -> None:
        """Where screening failed a number is worth nothing but for itself."""
        self._seen[orders - SCREEN * len(self.tasks)] = values
        self.learn(orders)

    def orders(self, plane: int) -> Ids:
        ids = self._planes.ids[plane]
        computed = ids[self._asked[plane]]
        return np.concatenate([computed, SCREEN * len(self.tasks) + ids]) if self.screens else computed

    def step(self, plane: int) -> bool:
        ids, asked = self._planes.ids[plane], self._asked[plane]
        number, seen, places = self._number[ids], self._seen[ids], ids[:0]
        if self._first[plane]:
            self._first[plane] = False
            places = rough_places(logs_above(seen, np.ones(len(seen))).reshape(self._planes.shape), asked)
        if not len(places):
            places = wanted(self._planes.at, logs_above(number, seen), asked, self._error, self._most)
        asked[places] = True
        return bool(len(places))
