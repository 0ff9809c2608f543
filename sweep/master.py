"""Rank 0: hands out batches, keeps count, writes what must be written here, and computes in a thread meanwhile."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.backoff import Backoff
from sweep.batches import Batches
from sweep.messages import receive_report, send_work
from sweep.tasks import Ids
from sweep.worker import OwnWorker, failures
from sweep.writers import Writer

NOTHING = np.empty(0, np.int64)


@dataclass
class Count:
    """How far the run is; read by progress and log."""

    done: int = 0
    failed: int = 0


class Master:
    """One run's bookkeeping. `comm` is None for one process."""

    def __init__(
        self,
        comm: Any | None,
        batches: Batches,
        own: OwnWorker,
        writer: Writer,
        rows_come: bool,
        stopping: Callable[[], bool] = lambda: False,
    ) -> None:
        """`rows_come`: workers send their rows here, instead of writing them themselves.

        Once `stopping` says so nothing more is handed out; what is running is finished and kept.
        """
        self._comm, self._batches, self._own, self._writer = comm, batches, own, writer
        self._rows_come, self._stopping = rows_come, stopping
        self._assigned: dict[int, Ids] = {}
        self._serving = set(range(1, comm.size)) if comm is not None else set()
        self.count = Count()

    def run(self, tick: Callable[[], None]) -> None:
        """Serve until every worker has been told to stop; `tick` is called all the while."""
        backoff = Backoff()
        while self._serving or not self._own.idle or self._more():
            if self._serve_worker() or self._serve_own():
                backoff.reset()
            else:
                backoff.wait()
            tick()

    def _more(self) -> bool:
        return len(self._batches) > 0 and not self._stopping()

    def _next(self) -> Ids:
        return self._batches.take() if self._more() else NOTHING

    def _serve_worker(self) -> bool:
        if self._comm is None or (report := receive_report(self._comm, self._rows_come)) is None:
            return False
        worker, done, failed, rows = report
        batch = self._next()
        send_work(self._comm, worker, batch)  # before anything else: the worker waits for it
        if rows is not None:
            self._writer.write(self._assigned[worker], rows)
        self._add(done, failed)
        self._assigned[worker] = batch
        if not len(batch):
            self._serving.discard(worker)
        return True

    def _serve_own(self) -> bool:
        finished = self._own.collect()
        if finished is not None:
            self._keep(*finished)
        if self._own.idle and self._more():
            self._own.start(self._next())
            return True
        return finished is not None

    def _keep(self, ids: Ids, rows: NDArray[np.void]) -> None:
        self._writer.write(ids, rows)
        failed = failures(rows)
        self._add(len(rows) - failed, failed)

    def _add(self, done: int, failed: int) -> None:
        self.count.done += done
        self.count.failed += failed
