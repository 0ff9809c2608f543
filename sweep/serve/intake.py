"""What becomes of finished rows on rank 0 besides being written: a search learns from them, the store keeps them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError
from sweep.plan.batches import NO_TASKS, Batches, batches_of
from sweep.plan.parts import Predict
from sweep.plan.search import COMPUTE, Search
from sweep.plan.tasks import Ids
from sweep.serve.worker import Job, write_computed
from sweep.store.known import Alike, Known, told_of
from sweep.store.writers import Writer


class Intake:
    """Takes rows in, and says what is to be computed next."""

    def __init__(
        self, job: Job, search: Search | None, writer: Writer, store: Known | None = None, alike: Alike | None = None
    ) -> None:
        """`alike`: the ranks whose rows the store keeps."""
        self._job, self._search, self._writer, self._store, self._alike = job, search, writer, store, alike

    def rows(self, orders: Ids, rows: NDArray[np.void]) -> Ids:
        """Take in what was computed; the orders that follow from it."""
        if self._store is not None and self._alike is not None:
            kept = self._alike.are_of(rows)
            self._store.keep(orders[kept], rows[kept])
        return self.to_compute(self._learnt(orders, rows))

    def batches(self, left: NDArray[Any], predict: Predict, ranks: int) -> Batches:
        """What is to be computed of `left`: of a search its orders, of a grid one flag for each task."""
        if self._store is None and self._search is None:
            return batches_of(left, predict, ranks)
        orders = self.to_compute(np.flatnonzero(left) if self._search is None else left)
        return Batches(orders, predict(orders), ranks)

    def to_compute(self, orders: Ids) -> Ids:
        """Those of the orders that the store cannot answer, and those that follow from its answers."""
        left = [NO_TASKS]
        while len(orders):
            found, rows = self._found(orders)
            left.append(np.setdiff1d(orders, found))
            if not len(found):
                break
            write_computed(self._writer, self._job, found, rows)
            orders = self._learnt(found, rows)
        return np.sort(np.concatenate(left))

    def _found(self, orders: Ids) -> tuple[Ids, NDArray[np.void]]:
        """What the store has of these, in ascending order. One that cannot be read any more ends no run."""
        if self._store is not None:
            try:
                found, rows = self._store.find(orders, self._writer)
                order = np.argsort(found)
                return found[order], rows[order]
            except InputError as error:
                told_of(error)
                self._store = None
        return NO_TASKS, np.empty(0, self._job.layout)

    def _learnt(self, orders: Ids, rows: NDArray[np.void]) -> Ids:
        """What the search asks for after these rows; keeps what was screened and tried."""
        search = self._search
        if search is None:
            return NO_TASKS
        seen = self._job.asks(orders) != COMPUTE
        if seen.any():
            self._writer.seen(orders[seen] - len(self._job.tasks), rows[search.of][seen])
            search.tell_seen(orders[seen], rows[search.of][seen])
        search.tell(orders[~seen], rows[~seen])
        return search.ask()
