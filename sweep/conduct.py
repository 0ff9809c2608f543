"""`sweep run`: prepare on rank 0, compute on all, print how it ended."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from kernel.status import SENTENCES
from kernel.version import source_hash
from sweep.errors import BAD_INPUT, STOPPED_EARLY, InputError, status_of
from sweep.grammar import refuse
from sweep.log import conclude, say
from sweep.machine import compiled_for
from sweep.page import Page
from sweep.plan.batches import Batches, computing_ranks
from sweep.plan.forecast import predict_asked
from sweep.plan.search import SCREEN, Search, first_alike, in_words
from sweep.plan.tasks import Ids
from sweep.prepare import Options, Prepared, prepare
from sweep.schema import DONE, RUN, RUNS, text_of
from sweep.serve.compiling import compile_once, what_follows
from sweep.serve.grace import Grace
from sweep.serve.guests import Guests, other_kinds
from sweep.serve.intake import Intake
from sweep.serve.master import Count, Master
from sweep.serve.messages import abort, meet, of_rank_0
from sweep.serve.progress import Efficiency, Progress
from sweep.serve.pulse import Pulse
from sweep.serve.stops import Stops, leave_it_to_the_master, stop_on_signal
from sweep.serve.watch import NodeWatch
from sweep.serve.worker import Job, OwnWorker, Usage, work, write_computed
from sweep.site import schedulers, walltime
from sweep.store import searched, structure, table, writers
from sweep.store.known import Alike, Known, told_of
from sweep.store.moved import Moved
from sweep.store.runs import kinds_of, new_run, places_text
from sweep.store.shelf import UselessStoreError
from sweep.tell.text import duration

COMPILED_AFTER = 5.0  # seconds: timing the kernel takes less unless it is compiled first


def run(comm: Any | None, options: Options) -> int:
    """Compute what is left of the table; the exit status. InputError on rank 0 (others return BAD_INPUT)."""
    if comm is not None and comm.rank > 0:
        leave_it_to_the_master()
        with Pulse(comm) as pulse:
            return _worker(comm, pulse)
    with ExitStack() as stack:
        stopping = stack.enter_context(stop_on_signal())
        pulse = stack.enter_context(Pulse(comm))
        held = stack.enter_context(ExitStack())
        prepared = of_rank_0(comm, lambda: prepare(comm, options, held, pulse))
        assert prepared is not None
        stops = Stops(stopping, prepared.deadline, options.max_fails)
        with _watched(comm, pulse, held.close) as watch:
            return _end(comm, watch, _with_page(comm, prepared, stops, pulse, options.page))


@contextmanager
def _watched(comm: Any | None, pulse: Pulse, let_go: Callable[[], None] = lambda: None) -> Iterator[NodeWatch | None]:
    """All ranks do this together: one that fails says why, lets go of what it holds, and ends the others: they wait."""
    if comm is None:
        yield None
        return
    pulse.watch = watch = NodeWatch(comm)
    try:
        yield watch
    except Exception as error:
        watch.dismiss()
        if isinstance(error, InputError):  # the table cannot be opened or written any more, or a sampler fails
            let_go()
            refuse("sweep", error.problems)
            abort(comm, BAD_INPUT)
        raise


def _open_writer(prepared: Prepared, comm: Any | None, pulse: Pulse) -> writers.Writer:
    if prepared.writer == "mpio":
        meet(comm)  # HDF5 would wait for rank 0, which reads the whole table first, and let no pulse be felt meanwhile
        writer: writers.Writer = writers.Mpio(prepared.path, comm, prepared.flush_every)
    else:
        writer = writers.Gather(prepared.path, prepared.flush_every)
    pulse.watch_disk(writer.waiting.seconds)
    return writer


def _worker(comm: Any, pulse: Pulse) -> int:
    prepared: Prepared | None = of_rank_0(comm, lambda: None)
    if prepared is None:
        return BAD_INPUT
    with _watched(comm, pulse) as watch:
        compile_once(comm, prepared.job)
        _kinds(comm)
        if prepared.store is not None:
            comm.gather(prepared.job.numerics_of_first())
        writer = _open_writer(prepared, comm, pulse) if prepared.writer == "mpio" else None
        comm.gather(work(comm, prepared.job, writer))
        if writer is not None:
            writer.close()
        return _end(comm, watch)


def _end(comm: Any, watch: NodeWatch | None, status: int = BAD_INPUT) -> int:
    """Wait for all ranks, so that they end together; the exit status, which rank 0 knows."""
    if watch is not None:
        watch.end()
        meet(comm)
        watch.close()
        status = comm.bcast(status)
    return status


def _with_page(comm: Any | None, prepared: Prepared, stops: Stops, pulse: Pulse, page: Path | None) -> int:
    """The last page is made while the other ranks wait: the first to end MPI would end all."""
    with Page(page, prepared.path) as shown:
        status = _serve(comm, prepared, stops, pulse, shown)
        if status == STOPPED_EARLY:
            shown.hurry()
        return status


def _serve(comm: Any | None, prepared: Prepared, stops: Stops, pulse: Pulse, page: Page) -> int:
    started, job, ranks = time.monotonic(), prepared.job, 1 if comm is None else comm.size
    unit = compile_once(comm, job)
    compiled = time.monotonic() - started
    if compiled > COMPILED_AFTER:
        say(f"compiled the kernel in {compiled:.0f} s; {what_follows()}")
    with table.reading(prepared.path) as file:
        (left, search), slot = _left(file, prepared), table.next_slot(file)
        run_at = structure.place(file[RUNS])[0] + slot * RUN.itemsize
        earlier = kinds_of(table.runs(file))
        behind = table.RUNS_MAX if table.free_slot(file) is None else slot + 1  # of a full list `slot` may lie within
    hosts, kinds = [*pulse.hosts], _kinds(comm)
    alike, store = _store(comm, prepared, search is None, behind)
    writer = _open_writer(prepared, comm, pulse)
    moved = Moved(prepared.path, run_at, writer.waiting)
    stops = stops.also(lambda: moved.is_so)
    intake = Intake(job, search, writer, store, alike)

    def predicted(orders: Ids) -> NDArray[np.float64]:
        return unit * _work(job, orders)

    def more(orders: Ids, rows: NDArray[np.void]) -> tuple[Ids, NDArray[np.float64]]:
        new = intake.rows(orders, rows)
        return new, predicted(new)

    batches = intake.batches(left, predicted, ranks)
    computing = computing_ranks(ranks)
    own = OwnWorker(job) if computing == ranks else None
    _say_start(prepared, batches, ranks, computing, store)
    if len(batches) and (others := {*earlier, *kinds} - {kinds[0]}):
        say(other_kinds("some rows of this table", others))
    rows_come = prepared.writer == "gather"

    def met(more_hosts: Sequence[str], more_kinds: Sequence[str]) -> None:
        hosts.extend(more_hosts)
        kinds.extend(more_kinds)
        record["hosts"] = places_text(hosts, kinds, RUN["hosts"].itemsize)

    guests = None if search else Guests(prepared.path, job, batches, ranks, writer.waiting, alike, met)
    more_comes = more if job.shown else None
    write = partial(write_computed, writer, job)
    master = Master(comm, batches, own, write, rows_come, stops.fits, more_comes, job.layout, guests)
    where = places_text(hosts, kinds, RUN["hosts"].itemsize), schedulers.job(os.environ)
    record = new_run(len(batches), prepared.writer, source_hash(), *where, ranks)
    record["computing"], record["work_left_at_start"] = computing, batches.seconds_left
    progress = Progress(writer, slot, batches, master.count, record, more=search is not None)
    grace = Grace(stops.asked)

    def tick() -> None:
        progress.tick()
        moved.look()
        page.tick()
        if grace.is_over(master.longest):
            since = f"{prepared.path} was moved or deleted" if moved.is_so else "after the signal to stop"
            pulse.give_up(f"{since}, what was under way has not ended in time")

    efficiency = _measured(comm, master, tick)
    if guests is not None:
        guests.close()
    progress.end(efficiency)
    if own is not None:
        own.close()
    if store is not None:
        store.close()
    writer.close()
    moved.refuse()
    return _end_of_run(prepared, time.monotonic() - started, efficiency, stops, master.count, batches.left)


def _kinds(comm: Any | None) -> list[str]:
    """On rank 0 the kind of processor of every rank; all ranks do this together."""
    return [compiled_for()] if comm is None else comm.gather(compiled_for()) or []


def _left(file: h5py.File, prepared: Prepared) -> tuple[NDArray[Any], Search | None]:
    """What is left of the table: orders and the search that asks for further ones, or one flag for each task."""
    if searched.is_searched(table.resolved(file)):
        try:
            return searched.left(file, prepared.retry_failed, prepared.sampler)
        except InputError:  # a sampler that cannot begin
            if prepared.is_new:
                prepared.path.unlink()
            raise
    return ~table.finished(file, prepared.retry_failed), None


def _store(comm: Any | None, prepared: Prepared, whole: bool, slot: int) -> tuple[Alike | None, Known | None]:
    """The store, if one is used, and the ranks whose rows may go there; `slot`: the first free one of the list."""
    if prepared.store is None:
        return None, None
    job = prepared.job
    here, what = job.numerics_of_first(), prepared.what | {"numerics": job.numerics()}
    alike = Alike(here)
    alike.meet(0, [here] if comm is None else comm.gather(here))
    try:
        return alike, Known(prepared.store, what, job.tasks, job.layout, prepared.path, slot, whole, job.screens)
    except UselessStoreError as error:
        told_of(error)
        return None, None


def _work(job: Job, orders: Ids) -> NDArray[np.float64]:
    """Predicted work of these orders."""
    asks, ids, work = job.asks(orders), orders % len(job.tasks), np.empty(len(orders))
    what = job.integrator, job.certify, job.model, len(job.quantities), job.screens
    for asked in np.unique(asks).tolist():
        which = asks == asked
        like = ids[which]
        if asked == SCREEN:  # as much for all that share a linear chain, so that a batch holds them
            like = first_alike(job.tasks, like, len(job.quantities))
        work[which] = predict_asked(job.tasks, like, asked, *what)
    return work


def _measured(comm: Any | None, master: Master, tick: Callable[[], None]) -> Efficiency:
    """Run the master to the end, then gather what every rank did with its time."""
    start, cpu = time.perf_counter(), time.thread_time()
    master.run(tick)
    end, serving, count = time.perf_counter(), time.thread_time() - cpu, master.count
    tail = end - count.dry if count.dry is not None else 0.0
    ranks = [Usage(count.own, max(0.0, end - start - count.own)), *(comm.gather(None)[1:] if comm is not None else [])]
    return Efficiency(ranks, end - start, tail, count.finished, serving)


def _say_start(prepared: Prepared, batches: Batches, ranks: int, computing: int, store: Known | None) -> None:
    if store is not None:
        later = "" if prepared.extent is None else ", and more as the search asks for them"
        say(f"{store.taken} rows taken from the store {store.folder}{later}")
    own = "rank 0 computes too" if computing == ranks else "rank 0 only serves"
    tasks = f"{len(prepared.job.tasks)} tasks" if prepared.extent is None else in_words(prepared.extent)
    with_screening = prepared.extent is not None and len(batches) > prepared.extent.at_most
    kinds = ", screening included" if with_screening else ""  # more than there are tasks
    until = "" if prepared.deadline is None else f"; until {walltime.as_text(prepared.deadline)}"
    say(
        f"{tasks}, {len(batches)} left{kinds}; {ranks} rank{'s' * (ranks > 1)}, {own}; "
        f"writer {prepared.writer} ({prepared.why}); {prepared.job.integrator}; "
        f"predicted {duration(max(batches.longest, batches.seconds_left / computing))}{until}"
    )


def _any_unchecked(file: h5py.File) -> bool:
    """Whether a done row was not checked for chaos."""
    return any(not rows["checked"].all() for rows in table.done_rows(file))


def _end_of_run(
    prepared: Prepared, seconds: float, efficiency: Efficiency, stops: Stops, count: Count, left: int
) -> int:
    """Print how the run ended; the exit status."""
    with table.reading(prepared.path) as file:
        kinds, seen_left = searched.counts(file)
        seen = searched.seen(file)
        unchecked = not prepared.job.certify and _any_unchecked(file)  # rows that were taken over may be
    done, failed = kinds[text_of(DONE)], kinds.total() - kinds[text_of(DONE)]
    if (unseen := seen_left - left) > 0:
        say(f"{unseen} rows that were reported finished are not in the table, as this node sees it: run again")
    if left:
        say(f"stopped early: {stops.reason(count)}")
    # What failed in an earlier run and was to be tried again is left, as the exit status says.
    untried = min(left, max(0, failed - count.failed)) if prepared.retry_failed else 0
    if untried:
        say(f"{untried} of the rows left failed in an earlier run and were not tried again: run with --retry-failed")
    for kind in sorted(kinds.keys() - {text_of(DONE)}):
        say(f"{kinds[kind]} row{'s' * (kinds[kind] > 1)} failed, {kind}: {SENTENCES.get(kind, 'why is not known')}")
    if count.done + count.failed:
        say(str(efficiency))
    where = f"table {prepared.path}{'; not checked for chaos' if unchecked else ''}"
    looked = "" if seen is None else f"; {seen.in_words()}"
    # A table does not know what a user's sampler asks for.
    known_left = seen_left + untried if prepared.sampler is None else left
    conclude(f"{done} done, {failed - untried} failed, {known_left} left{looked}; wall time {seconds:.1f} s; {where}")
    return status_of(failed, unseen > 0 or (left > 0 and not stops.failed_too_often(count)))
