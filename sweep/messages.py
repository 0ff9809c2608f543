"""What master and workers say to each other: plain numpy buffers, no pickle, nothing in the tags but the kind.

A worker sends REPORT (rows done, rows failed), followed by ROWS when rank 0 writes; an empty report asks for the first
work. The master answers WORK: the numbers of the tasks to do; no number means stop.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.backoff import Backoff
from sweep.schema import ROW
from sweep.tasks import Ids

REPORT, ROWS, WORK = 1, 2, 3


def wait_for(comm: Any, source: int, tag: int) -> Any:
    """Sleep until a message is there; its status."""
    from mpi4py import MPI

    status, backoff = MPI.Status(), Backoff()
    while not comm.Iprobe(source, tag, status):
        backoff.wait()
    return status


def send_work(comm: Any, worker: int, ids: Ids) -> None:
    """Hand tasks to a worker."""
    comm.Send(np.ascontiguousarray(ids, np.int64), worker, WORK)


def receive_work(comm: Any) -> Ids:
    """The next tasks; empty means stop."""
    from mpi4py import MPI

    status = wait_for(comm, 0, WORK)
    ids = np.empty(status.Get_count(MPI.INT64_T), np.int64)
    comm.Recv(ids, 0, WORK)
    return ids


def send_report(comm: Any, done: int, failed: int, rows: NDArray[np.void] | None) -> None:
    """Say what was finished; with the rows where rank 0 writes them."""
    comm.Send(np.array([done, failed], np.int64), 0, REPORT)
    if rows is not None and len(rows):
        comm.Send(rows.view(np.uint8), 0, ROWS)


def receive_report(comm: Any, with_rows: bool) -> tuple[int, int, int, NDArray[np.void] | None] | None:
    """(worker, done, failed, rows) if a worker has reported, else None; never waits for work to finish."""
    from mpi4py import MPI

    status = MPI.Status()
    if not comm.Iprobe(MPI.ANY_SOURCE, REPORT, status):
        return None
    worker, report = status.Get_source(), np.empty(2, np.int64)
    comm.Recv(report, worker, REPORT)
    done, failed = report.tolist()
    if not with_rows or done + failed == 0:
        return worker, done, failed, None
    rows = np.empty(done + failed, ROW)
    comm.Recv(rows.view(np.uint8), worker, ROWS)
    return worker, done, failed, rows
