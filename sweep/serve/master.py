"""Rank 0 of a run: it hands out batches, counts rows, writes those that come here, and computes in a thread."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.plan.batches import NO_TASKS, Batches
from sweep.plan.tasks import Ids
from sweep.schema import ROW
from sweep.serve.guests import Guests, next_order
from sweep.serve.messages import Backoff, Report, Reports, send_work
from sweep.serve.worker import OwnWorker, failures

More = Callable[[Ids, NDArray[np.void]], tuple[Ids, NDArray[np.float64]]]
REPORTS_AT_ONCE = 256  # served before rank 0's own rows and the clock are looked after: a few milliseconds


@dataclass
class Count:
    """How far the run is, for progress and log."""

    done: int = 0
    failed: int = 0
    requests: int = 0
    added: int = 0  # tasks that were not known at the start
    finished: float = 0.0  # predicted core seconds of the finished tasks
    running: float = 0.0  # predicted core seconds of the tasks handed out and not finished
    real: float = 0.0  # core seconds that the finished tasks took
    own: float = 0.0  # those of them that rank 0 computed
    dry: float | None = None  # time.perf_counter when a rank first found nothing more to do

    @property
    def ratio(self) -> float:
        """Real over predicted time of the finished tasks; 1 while there are none."""
        return self.real / self.finished if self.finished > 0 and self.real > 0 else 1.0


class Master:
    """Rank 0's part of a run. `comm` is None for one process, `own` is None where rank 0 only serves."""

    def __init__(
        self,
        comm: Any | None,
        batches: Batches,
        own: OwnWorker | None,
        write: Callable[[Ids, NDArray[np.void]], None],
        rows_come: bool,
        fits: Callable[[Count], float] = lambda _: math.inf,
        more: More | None = None,
        layout: np.dtype[Any] = ROW,
        guests: Guests | None = None,
    ) -> None:
        """`write`: stores finished rows. `rows_come`: workers send their rows here, instead of writing them themselves.

        `fits` gives how many predicted seconds may be started. Where not even the shortest task fits, nothing more is
        handed out; the running tasks are finished and kept. `more`: takes in finished rows, and gives the tasks
        that they lead to, and their predicted seconds; workers send their rows here, whoever writes. `layout`: of
        these rows. `guests`: the processes that join the run.
        """
        self._guests = guests
        self._comm, self._batches, self._own, self._write = comm, batches, own, write
        self._rows_come, self._fits, self._more, self._layout = rows_come, fits, more, layout
        self._running: dict[int, tuple[Ids, float]] = {}  # by rank, with their predicted seconds
        self._news = list[tuple[Ids, NDArray[np.void]]]()  # reported, and not yet taken in by `more`
        self._dry: list[int] = []  # workers that sleep until the end, when all close the table together
        self.count = Count()

    def run(self, tick: Callable[[], None]) -> None:
        """Serve until every rank has found nothing more to do; `tick` is called all the while."""
        reports, backoff = None, Backoff()
        if self._comm is not None:
            reports = Reports(self._comm, self._layout)
            for worker in range(1, self._comm.size):
                self._hand_out(worker)
        if self._own is not None:
            self._start_own(self._own)
        while self._running or (self._guests is not None and self._guests.busy):
            served = reports is not None and self._serve(reports)
            if self._guests is not None and self._guests.is_time():
                with self._guests.waiting.counted():
                    self._serve_guests(self._guests)
            if (self._own is not None and self._serve_own(self._own)) or served:
                backoff.reset()
            else:
                backoff.wait()
            self._take_in()
            tick()
        for worker in self._dry:
            send_work(self._comm, worker, NO_TASKS)
        if reports is not None:
            reports.close()

    @property
    def longest(self) -> float:
        """Seconds that the longest of the batches under way should take, as those finished show."""
        return self.count.ratio * max((predicted for _, predicted in self._running.values()), default=0.0)

    def _next(self, rank: int) -> Ids:
        batches = self._batches
        ids = batches.take(self._fits(self.count))
        if len(ids):
            self._running[rank] = ids, batches.taken
            self.count.running += batches.taken
        elif self.count.dry is None:
            self.count.dry = time.perf_counter()
        return ids

    def _hand_out(self, worker: int) -> None:
        if len(ids := self._next(worker)):
            send_work(self._comm, worker, ids)
        else:
            self._dry.append(worker)

    def _serve(self, reports: Reports) -> bool:
        """Answer the workers that have reported; whether there were any."""
        for served in range(REPORTS_AT_ONCE):
            if (report := reports.next()) is None:
                return served > 0
            self._answer(reports, report)
        return True

    def _answer(self, reports: Reports, report: Report) -> None:
        worker, done, failed, microseconds = report
        ids, predicted = self._running.pop(worker)
        self._add(done, failed, predicted, 1e-6 * microseconds)
        self.count.requests += 1
        rows = reports.rows(report) if self._rows_come or self._more is not None else None
        self._hand_out(worker)  # before its rows are written: the worker waits for tasks
        if rows is not None:
            if self._rows_come:
                self._write(ids, rows)
            self._news.append((ids, rows))

    def _take_in(self) -> None:
        """Add the tasks that the rows lead to which have come, all at once: the more there are, the less each takes."""
        news, self._news = self._news, []
        if self._more is None or not news:
            return
        ids, seconds = self._more(np.concatenate([ids for ids, _ in news]), np.concatenate([rows for _, rows in news]))
        if not len(ids):
            return
        self._batches.add(ids, seconds)
        self.count.added += len(ids)
        self._wake()

    def _wake(self) -> None:
        """There is more to do."""
        self.count.dry = None
        woken, self._dry = self._dry, []
        for worker in woken:
            self._hand_out(worker)
        if self._own is not None and self._own.idle:
            self._start_own(self._own)

    def _serve_guests(self, guests: Guests) -> None:
        for ids, rows, predicted in guests.taken():
            self._finish(ids, rows, predicted, float(rows["seconds"].sum()))
        fits = self._fits(self.count)
        for ids, predicted in guests.lost(self.count.ratio) if self._running or fits > 0 else guests.withdrawn():
            self.count.running -= predicted
            self._batches.add(ids, np.full(len(ids), predicted / len(ids)))
            self._wake()
        for guest in guests.wanting() if fits > 0 else ():
            if len((order := next_order(self._batches, fits)).ids):
                self.count.running += order.predicted
                guests.give(guest, *order)

    def _start_own(self, own: OwnWorker) -> None:
        if own.idle and len(ids := self._next(0)):
            own.start(ids)

    def _serve_own(self, own: OwnWorker) -> bool:
        if (finished := own.collect()) is None:
            return False
        ids, rows, seconds = finished
        _, predicted = self._running.pop(0)
        self._finish(ids, rows, predicted, seconds)
        self.count.own += seconds
        self._start_own(own)
        return True

    def _finish(self, ids: Ids, rows: NDArray[np.void], predicted: float, real: float) -> None:
        """Take in rows that no worker has counted: those of rank 0's thread, and of guests."""
        self._write(ids, rows)
        failed = failures(rows)
        self._add(len(rows) - failed, failed, predicted, real)
        self._news.append((ids, rows))

    def _add(self, done: int, failed: int, predicted: float, real: float) -> None:
        count = self.count
        count.done += done
        count.failed += failed
        count.running -= predicted
        count.finished += predicted
        count.real += real
