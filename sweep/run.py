"""`sweep run`: prepare on rank 0, compute on all, print how it ended."""

import os
import platform
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.version import source_hash
from sweep.errors import ALL_DONE, BAD_INPUT, SOME_FAILED, STOPPED_EARLY, InputError
from sweep.log import conclude, say
from sweep.plan import speed
from sweep.plan.batches import Batches, computing_ranks
from sweep.plan.cost import predict_all
from sweep.plan.tasks import Ids
from sweep.prepare import Options, Prepared, prepare
from sweep.schema import DONE, RUN, text_of
from sweep.serve.master import NO_TASKS, Count, Master
from sweep.serve.messages import meet
from sweep.serve.progress import Efficiency, Progress
from sweep.serve.stops import Stops, leave_it_to_the_master, stop_on_signal
from sweep.serve.watch import Watch
from sweep.serve.worker import OwnWorker, Usage, work
from sweep.site import schedulers, walltime
from sweep.store import searched, table, writers
from sweep.store.runs import hosts_text, new_run

COMPILED_AFTER = 5.0  # seconds: timing the kernel takes less unless it is compiled first


def run(comm: Any | None, options: Options) -> int:
    """Compute what is left of the table; the exit status. InputError on rank 0 (others return BAD_INPUT)."""
    if comm is not None and comm.rank > 0:
        leave_it_to_the_master()
        return _worker(comm)
    with ExitStack() as stack:
        stopping = stack.enter_context(stop_on_signal())
        prepared, problem = None, None
        try:
            prepared = prepare(comm, options, stack)
        except InputError as error:
            problem = error
        if comm is not None:
            meet(comm)
            comm.bcast(prepared)
        if problem is not None:
            raise problem
        assert prepared is not None
        try:
            return _master(comm, prepared, Stops(stopping, prepared.deadline, options.max_fails))
        except InputError as error:  # the table cannot be opened any more
            if comm is not None:  # the workers wait
                say(str(error))
                comm.Abort(BAD_INPUT)
            raise


def _open_writer(prepared: Prepared, comm: Any | None) -> writers.Writer:
    if prepared.writer == "mpio":
        return writers.Mpio(prepared.path, comm, prepared.flush_every)
    return writers.Gather(prepared.path, prepared.flush_every)


def _worker(comm: Any) -> int:
    meet(comm)
    prepared: Prepared | None = comm.bcast(None)
    if prepared is None:
        return BAD_INPUT
    watch = Watch(comm)
    try:
        comm.gather(platform.node())
        meet(comm)  # rank 0 compiles the kernel, the others find it in the cache
        writer = _open_writer(prepared, comm) if prepared.writer == "mpio" else None
        comm.gather(work(comm, prepared.job, writer))
        if writer is not None:
            writer.close()
        return int(_end(comm, watch))
    except Exception as error:
        watch.dismiss()
        if isinstance(error, InputError):  # the table cannot be written any more
            say(str(error))
            comm.Abort(BAD_INPUT)
        raise


def _end(comm: Any, watch: Watch, status: int | None = None) -> int:
    """Wait for all ranks, so that they end together; rank 0's exit status."""
    watch.end()
    meet(comm)
    return int(comm.bcast(status))


def _master(comm: Any | None, prepared: Prepared, stops: Stops) -> int:
    if comm is None:
        return _serve(None, prepared, stops)
    watch = Watch(comm)
    try:
        return _end(comm, watch, _serve(comm, prepared, stops))
    except Exception:
        watch.dismiss()
        raise


def _serve(comm: Any | None, prepared: Prepared, stops: Stops) -> int:
    started, job, ranks = time.monotonic(), prepared.job, 1 if comm is None else comm.size
    hosts = [platform.node()] if comm is None else comm.gather(platform.node())
    unit = speed.measure()
    compiled = time.monotonic() - started
    if compiled > COMPILED_AFTER:
        say(f"compiled the kernel in {compiled:.0f} s; the next run finds it in the cache")
    if comm is not None:
        meet(comm)
    with table.reading(prepared.path) as file:
        (left, search), slot = searched.left(file, prepared.retry_failed), table.next_slot(file)

    def predicted(ids: Ids) -> NDArray[np.float64]:
        return unit * predict_all(job.tasks, ids, job.integrator, job.certify)

    def more(ids: Ids, rows: NDArray[np.void]) -> tuple[Ids, NDArray[np.float64]]:
        new = search.more(ids, rows) if search else NO_TASKS
        return new, predicted(new)

    batches = Batches(left, predicted(left), ranks)
    computing = computing_ranks(ranks)
    own = OwnWorker(job) if computing == ranks else None
    _say_start(prepared, search.at_most if search else None, batches, ranks, computing)
    writer = _open_writer(prepared, comm)
    rows_come = prepared.writer == "gather"
    master = Master(comm, batches, own, writer, rows_come, stops.fits, more if search else None, job.layout)
    where = hosts_text(hosts, RUN["hosts"].itemsize), schedulers.job(os.environ)
    record = new_run(len(left), batches.seconds_left, ranks, computing, prepared.writer, source_hash(), *where)
    progress = Progress(writer, slot, batches, master.count, record, more=search is not None)
    efficiency = _measured(comm, master, progress.tick)
    progress.end(efficiency)
    if own is not None:
        own.close()
    writer.close()
    return _end_of_run(prepared, time.monotonic() - started, efficiency, stops, master.count, batches.left)


def _measured(comm: Any | None, master: Master, tick: Callable[[], None]) -> Efficiency:
    """Run the master to the end, then gather what every rank did with its time."""
    start, cpu = time.perf_counter(), time.thread_time()
    master.run(tick)
    end, serving, count = time.perf_counter(), time.thread_time() - cpu, master.count
    tail = end - count.dry if count.dry is not None else 0.0
    ranks = [Usage(count.own, max(0.0, end - start - count.own)), *(comm.gather(None)[1:] if comm is not None else [])]
    return Efficiency(ranks, end - start, tail, count.finished, serving)


def _say_start(prepared: Prepared, at_most: int | None, batches: Batches, ranks: int, computing: int) -> None:
    own = "rank 0 computes too" if computing == ranks else "rank 0 only serves"
    tasks = f"{len(prepared.job.tasks)} tasks" if at_most is None else f"adaptive, at most {at_most} tasks"
    until = "" if prepared.deadline is None else f"; until {walltime.as_text(prepared.deadline)}"
    say(
        f"{tasks}, {len(batches)} left; {ranks} rank{'s' * (ranks > 1)}, {own}; "
        f"writer {prepared.writer} ({prepared.why}); {prepared.job.integrator}; "
        f"predicted {batches.seconds_left / computing:.0f} s{until}"
    )


def _end_of_run(
    prepared: Prepared, seconds: float, efficiency: Efficiency, stops: Stops, count: Count, left: int
) -> int:
    """Print how the run ended; the exit status."""
    with table.reading(prepared.path) as file:
        kinds = table.kinds(file)
    done, failed = kinds[text_of(DONE)], kinds.total() - kinds[text_of(DONE)]
    if left:
        say(f"stopped early: {stops.reason(count)}")
    if count.done + count.failed:
        say(str(efficiency))
    where = f"table {prepared.path}{'' if prepared.job.certify else '; not checked for chaos'}"
    conclude(f"{done} done, {failed} failed, {left} left; wall time {seconds:.1f} s; {where}")
    if left and not stops.failed_too_often(count):
        return STOPPED_EARLY
    return SOME_FAILED if failed else ALL_DONE
