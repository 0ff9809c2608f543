"""Which tasks are handed out next: the longest first, in batches that shrink so that all ranks end together."""

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from sweep.plan.parts import PART, Parts, Predict, in_order
from sweep.plan.tasks import Ids

BATCH_MAX = 512  # rows of one message: 4 KB of numbers, which MPI sends without waiting for the receiver
BATCH_SHARE = 0.3  # of the predicted work that is left per rank: what is in one batch
SECONDS_MAX = 2.0  # of a batch, predicted: a stop waits for it, and a kill loses it
SECONDS_MIN = 0.02  # of a batch, predicted: keeps the cost of its messages below one percent (python -m tests.scale)
SECONDS_MIN_PER_RANK = 1e-5  # predicted: all ranks together ask no faster than the master serves (tests.scale)
NO_TASKS, NO_SECONDS = np.empty(0, np.int64), np.empty(0)
COMPUTING_MASTER_MAX = 128  # ranks: with more, serving needs all of rank 0's time (python -m tests.scale)


def computing_ranks(ranks: int) -> int:
    """How many of so many ranks compute: all, or all but rank 0."""
    return ranks if ranks <= COMPUTING_MASTER_MAX else ranks - 1


class Batches:
    """The tasks that are still to be done. Their order follows from the predicted work and the task numbers alone."""

    def __init__(self, ids: Ids, seconds: NDArray[np.float64], ranks: int, parts: Parts | None = None) -> None:
        """`seconds`: predicted for each task of `ids`, in the same order. `parts`: further tasks, after these."""
        self.ranks, self._seconds_min = ranks, max(SECONDS_MIN, SECONDS_MIN_PER_RANK * ranks)
        self.skipped, self.taken = 0, 0.0
        self._late: list[tuple[Ids, NDArray[np.float64]]] = []  # added, and not arranged yet
        self._late_count, self._late_seconds = 0, 0.0
        self._parts = parts
        self._arrange(*in_order(ids, seconds))

    def _arrange(self, ids: Ids, seconds: NDArray[np.float64]) -> None:
        self._ids, self._negative = ids, -seconds  # rises, so that it can be searched
        self._until = np.cumsum(seconds)
        self._all = float(self._until[-1]) if len(ids) else 0.0
        self._next, self._passed = 0, 0.0

    def add(self, ids: Ids, seconds: NDArray[np.float64]) -> None:
        """Add tasks that were not known before; their turn comes after all that are known.

        Were they put among these, the shortest of these would wait for ever, and with them what a search asks for next.
        """
        self._late.append((ids, seconds))
        self._late_count += len(ids)
        self._late_seconds += float(seconds.sum())

    def _merge(self) -> None:
        late, self._late, self._late_count, self._late_seconds = self._late, [], 0, 0.0
        ids, seconds = self._ids[self._next :], -self._negative[self._next :]
        every = np.concatenate([ids, *(i for i, _ in late)]), np.concatenate([seconds, *(s for _, s in late)])
        self._arrange(*in_order(*every))

    @property
    def _arranged(self) -> int:
        return len(self._ids) - self._next

    def __len__(self) -> int:
        return self._arranged + self._late_count + (len(self._parts) if self._parts else 0)

    @property
    def left(self) -> int:
        """How many tasks have not been handed out, the skipped ones included."""
        return len(self) + self.skipped

    @property
    def seconds_left(self) -> float:
        """Predicted core seconds that can still be handed out."""
        known = (self._all - self._passed if self._arranged else 0.0) + self._late_seconds
        return known + (self._parts.seconds_left if self._parts else 0.0)

    @property
    def longest(self) -> float:
        """Predicted seconds of the longest task that is arranged: with all ranks there are, work takes no less."""
        return -float(self._negative[self._next]) if self._arranged else 0.0

    @property
    def share(self) -> float:
        """Predicted seconds of which a rank should not be given more, so that all end together."""
        return BATCH_SHARE * self.seconds_left / self.ranks

    @property
    def ahead(self) -> float:
        """Predicted seconds of the next task; infinite where none is in order yet."""
        return -float(self._negative[self._next]) if self._arranged else math.inf

    def take(self, fits: float = math.inf) -> Ids:
        """The next batch, `taken` predicted seconds long; empty when nothing is left.

        Tasks of more than `fits` predicted seconds are `skipped` for good, and no batch is longer than `fits`.
        """
        self._skip(fits)
        if self._late and not self._arranged:
            self._merge()
            self._skip(fits)
        while self._parts and not self._arranged and fits > 0:
            self._arrange(*self._parts.next())
            self._skip(fits)
        first, done = self._next, self._passed
        limit = done + min(fits, SECONDS_MAX, max(self._seconds_min, self.share))
        ahead = self._until[first : first + BATCH_MAX]
        if not len(ahead):
            self.taken = 0.0
            return self._ids[:0]
        count = max(1, int(ahead.searchsorted(limit, "right")))
        self._next, self._passed = first + count, float(ahead[count - 1])
        self.taken = self._passed - done
        return self._ids[first : first + count]

    def _skip(self, fits: float) -> None:
        start = self._next
        if not self._arranged or -self._negative[start] <= fits:
            return
        self._next += int(self._negative[start:].searchsorted(-fits, "left"))
        self._passed = float(self._until[self._next - 1])
        self.skipped += self._next - start


def batches_of(left: NDArray[np.bool_], predict: Predict, ranks: int) -> Batches:
    """Of the tasks marked in `left`, one flag for each task of the sweep; those of a large sweep part by part."""
    if len(left) > PART:
        return Batches(NO_TASKS, NO_SECONDS, ranks, Parts(left, predict))
    ids = np.flatnonzero(left)
    return Batches(ids, predict(ids), ranks)


def wall_seconds(seconds: NDArray[np.float64], ranks: int) -> float:
    """Seconds until tasks of these predicted seconds are done in such batches, if each takes as predicted."""
    batches, free = Batches(np.arange(len(seconds)), seconds, ranks), [0.0] * computing_ranks(ranks)  # a heap
    while len(batches.take()):
        heapq.heapreplace(free, free[0] + batches.taken)
    return max(free)
