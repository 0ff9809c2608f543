"""What computes: rank 0's thread, and on every other rank a loop over messages. Here alone the kernel is called."""

import math
import time
import traceback
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from textwrap import indent
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kernel.halves import compile_half
from kernel.ke import results_of
from kernel.lattice import PAPER_MODEL, Model
from kernel.method import Integrator
from kernel.numerics import numerics
from kernel.quantities import QUANTITIES
from sweep.log import say
from sweep.plan.search import COMPUTE, SCREEN, how
from sweep.plan.tasks import Ids, TaskList
from sweep.schema import DONE, PARAMETERS, RAISED, blank_of, layout_of, seal
from sweep.serve.messages import Orders, send_report
from sweep.store.writers import Writer

T = TypeVar("T")


@dataclass(frozen=True)
class Job:
    """What every rank must know of the sweep."""

    tasks: TaskList
    integrator: Integrator
    certify: bool
    shown: bool = False  # rank 0 sees every row: what to compute next follows from it, or it keeps it for other sweeps
    quantities: tuple[str, ...] = ()  # that are asked for beside the kinetic energy
    varied: tuple[str, ...] = ()  # numbers of the model that differ from task to task
    model: Model | None = None  # the others; None: the paper's
    screens: float = 0.0  # of sweep.plan.search.Search

    @property
    def layout(self) -> np.dtype[Any]:
        """Of the table's rows."""
        return layout_of(self.quantities, self.varied)

    @property
    def chain(self) -> Model:
        """The model, the paper's where there is none."""
        return self.model or PAPER_MODEL

    def asks(self, orders: Ids) -> NDArray[np.int64]:
        """What these orders ask of their tasks (sweep.plan.search)."""
        return np.asarray(orders // len(self.tasks))

    def compile_half(self, second: bool) -> None:
        """See kernel.halves."""
        compile_half(second, self.chain, {name: QUANTITIES[name] for name in self.quantities})

    def numerics(self) -> str:
        """Which bits come of its chain here (kernel.numerics), whatever the tasks are that vary it."""
        # What the tasks vary may leave the others without a linear chain to compare with.
        return numerics(self.chain if self.chain.has_sound else PAPER_MODEL, self.quantities)

    def numerics_of_first(self) -> str:
        """The same of the first task's chain, which a table tells a guest."""
        first = self.tasks.columns(np.zeros(1, np.int64))
        model = self.chain.with_numbers({name: float(first[name][0]) for name in self.varied})
        return numerics(model, self.quantities)

    def results_of(self, columns: Mapping[str, NDArray[Any]], asked: int = COMPUTE) -> NDArray[np.void]:
        """What the kernel says of tasks with these inputs, each (n,)."""
        quantities = {name: QUANTITIES[name] for name in self.quantities}
        model, screened = self.chain, asked == SCREEN
        until, shared = self.screens if screened else math.inf, screened and not quantities
        by = how(asked, self.integrator, self.certify)
        return results_of(columns, *by, quantities=quantities, model=model, until=until, shared=shared)


@dataclass
class Usage:
    """What one rank did with its time, in seconds."""

    busy: float = 0.0  # computing and writing
    waited: float = 0.0  # for work
    waited_cpu: float = 0.0  # core seconds that the waiting took

    def waiting(self, wait: Callable[[], T]) -> T:
        """Call `wait`, and count the time that it takes."""
        start, cpu = time.perf_counter(), time.thread_time()
        answer = wait()
        self.waited += time.perf_counter() - start
        self.waited_cpu += time.thread_time() - cpu
        return answer


def compute_rows(job: Job, orders: Ids, rank: int) -> NDArray[np.void]:
    """The finished rows of these orders, sealed, in that order. A task that fails is a row with a status.

    One that was only screened or tried is done in any case: a number is nan where there is none.
    """
    asks, ids = job.asks(orders), orders % len(job.tasks)
    rows = blank_of(job.tasks.columns(ids), job.layout)
    rows["rank"] = rank
    for asked in np.unique(asks).tolist():
        places = np.flatnonzero(asks == asked)
        some = rows[places]
        _compute(some, job, ids[places], asked)
        rows[places] = some
    rows["status"][asks != COMPUTE] = DONE
    seal(rows)
    return rows


def _compute(rows: NDArray[np.void], job: Job, ids: Ids, asked: int) -> None:
    """Fill in the results of the rows, and say where the kernel raised an exception."""
    if (trouble := _fill(rows, job, ids, asked)) and len(ids) > 1:
        # One by one, so that a bug in the kernel costs the rows that it strikes, not the batch.
        troubles = [_fill(rows[i : i + 1], job, ids[i : i + 1], asked) for i in range(len(ids))]
    else:
        troubles = [trouble]
    for task_id, report in zip(ids, troubles, strict=False):
        if report:
            say(f"task {task_id} raised\n{indent(report.rstrip(), '  ')}")


def _fill(rows: NDArray[np.void], job: Job, ids: Ids, asked: int) -> str:
    """Fill in the results of the rows; the traceback where the kernel raised an exception, else nothing.

    The seconds of the batch are shared out by the force evaluations of each task.
    """
    start = time.perf_counter()
    try:
        results = job.results_of(job.tasks.columns(ids), asked)
    except Exception:
        rows["status"] = RAISED
        rows["seconds"] = time.perf_counter() - start
        return traceback.format_exc()
    for name in set(results.dtype.names or ()) & set(rows.dtype.names or ()) - set(PARAMETERS):
        rows[name] = results[name]
    work = results["site_evaluations"] + 1.0
    rows["seconds"] = (time.perf_counter() - start) * work / work.sum()
    return ""


def failures(rows: NDArray[np.void]) -> int:
    """How many of these finished rows failed."""
    return int(np.count_nonzero(rows["status"] != DONE))


def work(comm: Any, job: Job, writer: Writer | None) -> Usage:
    """Compute and report until the master says stop. `writer` is None where rank 0 writes."""
    orders, usage = Orders(comm), Usage()
    while len(numbers := usage.waiting(orders.wait)):
        start = time.perf_counter()
        rows = compute_rows(job, numbers, comm.rank)
        if writer is not None:
            write_computed(writer, job, numbers, rows)
        failed, seconds = failures(rows), time.perf_counter() - start
        usage.busy += seconds
        send_report(comm, len(rows) - failed, failed, seconds, rows if writer is None or job.shown else None)
    return usage


def write_computed(writer: Writer, job: Job, orders: Ids, rows: NDArray[np.void]) -> None:
    """Store the rows of orders, but of those that only screen or try a task, as they are no results."""
    computed = job.asks(orders) == COMPUTE
    if computed.any():
        writer.write(orders[computed], rows[computed])


class OwnWorker:
    """Rank 0's share of the work: one thread, which computes with the GIL released while the master serves."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self._pool = ThreadPoolExecutor(1)
        self._running: tuple[Ids, Future[tuple[NDArray[np.void], float]]] | None = None

    @property
    def idle(self) -> bool:
        """Whether it has no tasks, or all of its rows were collected."""
        return self._running is None

    def start(self, ids: Ids) -> None:
        """Begin computing tasks `ids`."""
        self._running = ids, self._pool.submit(self._compute, ids)

    def _compute(self, ids: Ids) -> tuple[NDArray[np.void], float]:
        job, start = self._job, time.perf_counter()
        rows = compute_rows(job, ids, 0)
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
