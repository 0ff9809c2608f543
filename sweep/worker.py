"""Computes what it is handed: rank 0 in a thread, every other rank in a loop over messages."""

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.method import Integrator
from sweep.compute import compute_rows
from sweep.messages import receive_work, send_report
from sweep.schema import DONE
from sweep.tasks import Ids, TaskList
from sweep.writers import Writer


@dataclass(frozen=True)
class Job:
    """What every rank must know."""

    tasks: TaskList
    integrator: Integrator
    certify: bool


def failures(rows: NDArray[np.void]) -> int:
    """How many of these finished rows failed."""
    return int(np.count_nonzero(rows["status"] != DONE))


def work(comm: Any, job: Job, writer: Writer | None) -> None:
    """Ask, compute, report, until the master says stop. `writer` is None where rank 0 writes."""
    send_report(comm, 0, 0, None)
    while len(ids := receive_work(comm)):
        rows = compute_rows(job.tasks, ids, job.integrator, job.certify, comm.rank)
        if writer is not None:
            writer.write(ids, rows)
        failed = failures(rows)
        send_report(comm, len(rows) - failed, failed, None if writer is not None else rows)


class OwnWorker:
    """Rank 0's share of the work: one thread, which computes with the GIL released while the master serves."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self._pool = ThreadPoolExecutor(1)
        self._running: tuple[Ids, Future[NDArray[np.void]]] | None = None

    @property
    def idle(self) -> bool:
        """Nothing handed out, or everything collected."""
        return self._running is None

    def start(self, ids: Ids) -> None:
        """Begin computing tasks `ids`."""
        job = self._job
        future = self._pool.submit(compute_rows, job.tasks, ids, job.integrator, job.certify, 0)
        self._running = ids, future

    def collect(self) -> tuple[Ids, NDArray[np.void]] | None:
        """The finished tasks and their rows, if there are any; raises what the thread raised."""
        if self._running is None or not self._running[1].done():
            return None
        ids, future = self._running
        self._running = None
        return ids, future.result()

    def close(self) -> None:
        """End the thread."""
        self._pool.shutdown()
