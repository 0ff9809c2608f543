"""Computes what it is handed: rank 0 in a thread, every other rank in a loop over messages."""

import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.method import Integrator
from sweep.plan.tasks import Ids, TaskList
from sweep.schema import DONE
from sweep.serve.compute import compute_rows
from sweep.serve.messages import Orders, send_report
from sweep.serve.usage import Usage
from sweep.store.writers import Writer


@dataclass(frozen=True)
class Job:
    """What every rank must know."""

    tasks: TaskList
    integrator: Integrator
    certify: bool
    adaptive: bool = False  # rank 0 sees every row, because what to compute next follows from it


def failures(rows: NDArray[np.void]) -> int:
    """How many of these finished rows failed."""
    return int(np.count_nonzero(rows["status"] != DONE))


def work(comm: Any, job: Job, writer: Writer | None) -> Usage:
    """Compute and report until the master says stop. `writer` is None where rank 0 writes."""
    orders, usage = Orders(comm), Usage()
    while len(ids := usage.waiting(orders.wait)):
        start = time.perf_counter()
        rows = compute_rows(job.tasks, ids, job.integrator, job.certify, comm.rank)
        if writer is not None:
            writer.write(ids, rows)
        failed, seconds = failures(rows), time.perf_counter() - start
        usage.busy += seconds
        send_report(comm, len(rows) - failed, failed, seconds, rows if writer is None or job.adaptive else None)
    return usage


class OwnWorker:
    """Rank 0's share of the work: one thread, which computes with the GIL released while the master serves."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self._pool = ThreadPoolExecutor(1)
        self._running: tuple[Ids, Future[tuple[NDArray[np.void], float]]] | None = None

    @property
    def idle(self) -> bool:
        """Nothing handed out, or everything collected."""
        return self._running is None

    def start(self, ids: Ids) -> None:
        """Begin computing tasks `ids`."""
        self._running = ids, self._pool.submit(self._compute, ids)

    def _compute(self, ids: Ids) -> tuple[NDArray[np.void], float]:
        job, start = self._job, time.perf_counter()
        rows = compute_rows(job.tasks, ids, job.integrator, job.certify, 0)
        return rows, time.perf_counter() - start

    def collect(self) -> tuple[Ids, NDArray[np.void], float] | None:
        """The finished tasks, their rows and seconds, if there are any; raises what the thread raised."""
        if self._running is None or not self._running[1].done():
            return None
        ids, future = self._running
        self._running = None
        return ids, *future.result()

    def close(self) -> None:
        """End the thread."""
        self._pool.shutdown()
