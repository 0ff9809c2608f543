"""Which tasks go out next: the longest first, in batches that shrink towards the end so that the tail is short."""

import numpy as np
from numpy.typing import NDArray

from sweep.tasks import Ids

BATCH_MAX = 256  # rows of one message
SHARE = 0.1  # of what is left, per rank, in one batch
SECONDS_MAX = 2.0  # predicted; bounds what a stop has to wait for, and what a kill can lose
SECONDS_MIN = 0.02  # predicted; keeps the cost of a message below one percent


class Batches:
    """The tasks still to do. Deterministic: the order follows from the predicted work and the task numbers."""

    def __init__(self, ids: Ids, seconds: NDArray[np.float64], ranks: int) -> None:
        """`seconds`: predicted for each task of `ids`, in the same order."""
        order = np.lexsort((ids, -seconds))
        self._ids, self._until = ids[order], np.cumsum(seconds[order])
        self._next, self._ranks = 0, ranks

    def __len__(self) -> int:
        return len(self._ids) - self._next

    @property
    def seconds_left(self) -> float:
        """Predicted core seconds not yet handed out."""
        return float(self._until[-1] - self._handed_out) if len(self) else 0.0

    @property
    def _handed_out(self) -> float:
        return float(self._until[self._next - 1]) if self._next else 0.0

    def take(self) -> Ids:
        """The next batch; empty when nothing is left."""
        share = SHARE * self.seconds_left / self._ranks
        limit = self._handed_out + min(SECONDS_MAX, max(SECONDS_MIN, share))
        end = int(np.searchsorted(self._until, limit, side="right"))
        end = min(max(end, self._next + 1), self._next + BATCH_MAX, len(self._ids))
        batch = self._ids[self._next : end]
        self._next = end
        return batch
