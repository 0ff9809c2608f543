"""What is left of a large sweep, part by part: a part is predicted and put in order only when its turn is near.

Numbers and predictions of 1e8 tasks are 5 GB, and to put them in order takes a minute. A part is some neighbouring
tasks, whose rows lie together on the disk too. The parts with the longest tasks come first, as their samples show, so
that at the end of the sweep only short ones are left.
"""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from sweep.plan.tasks import Ids

PART = 1 << 21  # tasks: some 200 MB while they are put in order (python -m tests.large); smaller sweeps are one part
SAMPLE = 256  # tasks of each part whose prediction stands for the others' until it is their turn

Seconds = NDArray[np.float64]
Predict = Callable[[Ids], Seconds]


def in_order(ids: Ids, seconds: Seconds) -> tuple[Ids, Seconds]:
    """The longest first, equal ones by number."""
    order = np.lexsort((ids, -seconds))
    return ids[order], seconds[order]


class Parts:
    """The tasks marked in `left` (one flag for each task of the sweep), of which `predict` tells the seconds."""

    def __init__(self, left: NDArray[np.bool_], predict: Predict) -> None:
        self._left, self._predict = left, predict
        sizes = [int(np.count_nonzero(left[first : first + PART])) for first in range(0, len(left), PART)]
        firsts = [k * PART for k, size in enumerate(sizes) if size]
        means = [self._mean(first) for first in firsts]
        order = sorted(range(len(firsts)), key=lambda k: -means[k])
        self._coming = [(firsts[k], size := sizes[firsts[k] // PART], size * means[k]) for k in order]
        self._pool, self._prepared = ThreadPoolExecutor(1), list[Future[tuple[Ids, Seconds]]]()

    def __len__(self) -> int:
        return sum(size for _, size, _ in self._coming)

    @property
    def seconds_left(self) -> float:
        """Predicted core seconds of these tasks, by their samples."""
        return sum(seconds for *_, seconds in self._coming)

    def next(self) -> tuple[Ids, Seconds]:
        """The tasks of the next part in their order, with their seconds; a thread goes on with the part after it."""
        if not self._prepared:
            self._begin()
        part = self._prepared.pop().result()
        del self._coming[0]
        if self._coming:
            self._begin()
        else:
            self._pool.shutdown()
        return part

    def _begin(self) -> None:
        self._prepared.append(self._pool.submit(self._part, self._coming[0][0]))

    def _part(self, first: int) -> tuple[Ids, Seconds]:
        ids = self._ids(first)
        return in_order(ids, self._predict(ids))

    def _ids(self, first: int) -> Ids:
        return first + np.flatnonzero(self._left[first : first + PART])

    def _mean(self, first: int) -> float:
        ids = self._ids(first)
        return float(self._predict(ids[:: -(-len(ids) // SAMPLE)]).mean())
