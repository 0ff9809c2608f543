"""Messages between master and workers: plain numpy buffers, no pickle, nothing in the tags but the kind.

The master begins with WORK for every worker: the numbers of its tasks; no number means stop. A worker answers with
REPORT (rows done, rows failed, microseconds of computing), followed by ROWS where rank 0 writes or must see them.
A REPORT asks for more WORK.
"""

import time
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError, of_system
from sweep.plan.batches import BATCH_MAX
from sweep.plan.tasks import Ids

T = TypeVar("T")
REPORT, ROWS, WORK = 1, 2, 3  # the tags of the messages
LOOKS_BEFORE_SLEEP = 40  # some 20 microseconds: messages come in bursts
FORWARDED = 0.2  # seconds for a launcher to pass on what a rank has said: an abort may end it before it has read that
SLEEP_MIN, SLEEP_MAX = 1e-5, 1e-3  # seconds; the longest delays a message by a twentieth of the shortest batch


class Backoff:
    """Waiting that does not spin, as a blocked receive would: some looks at once, then sleeps that double."""

    def __init__(self) -> None:
        self._looks, self._pause = LOOKS_BEFORE_SLEEP, SLEEP_MIN

    def wait(self) -> None:
        """Sleep, longer than the last time."""
        if self._looks:
            self._looks -= 1
            return
        time.sleep(self._pause)
        self._pause = min(SLEEP_MAX, 2.0 * self._pause)

    def reset(self) -> None:
        """A message came: be quick again."""
        self._looks, self._pause = LOOKS_BEFORE_SLEEP, SLEEP_MIN


class Report(NamedTuple):
    """What a worker has finished."""

    worker: int
    done: int
    failed: int
    microseconds: int


class Inbox:
    """Receives messages of one kind into one buffer by a persistent request, at half the cost of probing first."""

    def __init__(self, comm: Any, source: int, tag: int, numbers: int) -> None:
        from mpi4py import MPI

        self._kind, self.status, self.buffer = MPI.INT64_T, MPI.Status(), np.empty(numbers, np.int64)
        self._request = comm.Recv_init([self.buffer, numbers, self._kind], source, tag)
        self._request.Start()

    def came(self) -> bool:
        """Whether `buffer` holds a message, which stays there until `again` is called."""
        return bool(self._request.Test(self.status))

    def again(self) -> None:
        """Receive the next message into the buffer, whose content has been read."""
        self._request.Start()

    def close(self, pending: bool) -> None:
        """Expect nothing more; `pending`: a receive is posted that nobody will match."""
        if pending:
            self._request.Cancel()
            self._request.Wait()
        self._request.Free()

    def count(self) -> int:
        """Numbers in the message."""
        return int(self.status.Get_count(self._kind))


class Reports:
    """The master's end: takes what the workers report."""

    def __init__(self, comm: Any, layout: np.dtype[Any]) -> None:
        from mpi4py import MPI

        self._comm, self._layout, self._inbox = comm, layout, Inbox(comm, MPI.ANY_SOURCE, REPORT, 3)

    def next(self) -> Report | None:
        """One report if a worker has sent one; never waits for work to finish."""
        inbox = self._inbox
        if not inbox.came():
            return None
        report = Report(inbox.status.source, *inbox.buffer.tolist())
        inbox.again()
        return report

    def rows(self, report: Report) -> NDArray[np.void]:
        """The rows that follow a report."""
        rows = np.empty(report.done + report.failed, self._layout)
        self._comm.Recv(rows.view(np.uint8), report.worker, ROWS)
        return rows

    def close(self) -> None:
        """After the last report."""
        self._inbox.close(pending=True)


class Orders:
    """A worker's end: takes the tasks that the master sends."""

    def __init__(self, comm: Any) -> None:
        self._inbox = Inbox(comm, 0, WORK, BATCH_MAX)

    def wait(self) -> Ids:
        """Sleep until the next tasks come. No tasks means stop: nothing may be waited for after that."""
        inbox, backoff = self._inbox, Backoff()
        while not inbox.came():
            backoff.wait()
        ids = inbox.buffer[: inbox.count()].copy()
        if len(ids):
            inbox.again()
        else:
            inbox.close(pending=False)
        return ids


def meet(comm: Any) -> None:
    """Sleep until every rank is here: a blocking barrier would burn the cores of those that come early."""
    request, backoff = comm.Ibarrier(), Backoff()
    while not request.Test():
        backoff.wait()


def of_rank_0(comm: Any | None, make: Callable[[], T]) -> T | None:
    """What rank 0 makes, for all ranks; where it raises InputError, which it does here then, the others get None."""
    made: T | None = None
    problem: InputError | None = None
    if comm is None or comm.rank == 0:
        try:
            made = make()
        except InputError as error:
            problem = error
        except OSError as error:  # the other ranks must be told too
            if not (told := of_system(error)):
                raise
            problem = InputError(told)
    if comm is not None:
        meet(comm)
        made = comm.bcast(made)
    if problem is not None:
        raise problem
    return made


def abort(comm: Any, status: int) -> None:
    """End all ranks with this exit status, from any of them: what it has said on stderr is shown."""
    time.sleep(FORWARDED)
    comm.Abort(status)


def send_work(comm: Any, worker: int, ids: Ids) -> None:
    """Hand tasks to a worker."""
    comm.Send(ids, worker, WORK)


def send_report(comm: Any, done: int, failed: int, seconds: float, rows: NDArray[np.void] | None) -> None:
    """Report what was finished, with the rows where rank 0 wants them."""
    comm.Send(np.array([done, failed, round(1e6 * seconds)], np.int64), 0, REPORT)
    if rows is not None:
        comm.Send(rows.view(np.uint8), 0, ROWS)
