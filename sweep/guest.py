"""`sweep join TABLE`: compute for a run that is going on, until it ends or this process is asked to stop."""

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from kernel.version import source_hash
from sweep.errors import BAD_INPUT, InputError, status_of
from sweep.log import conclude, say
from sweep.machine import compiled_for
from sweep.plan.tasks import Columns, Ids
from sweep.schema import RESULTS, REUSED, axes_of, inputs_of, quantities_of, text_of
from sweep.serve.compiling import compile_once
from sweep.serve.messages import of_rank_0
from sweep.serve.pulse import Pulse
from sweep.serve.stops import stop_on_signal
from sweep.serve.worker import Job, compute_rows
from sweep.store import lease, mailbox, searched, table
from sweep.store.lock import is_held
from sweep.store.mailbox import BITS, GUEST, KIND, ORDER, ROWS, DamagedError, Sign, Watched
from sweep.store.writers import Waiting

T = TypeVar("T")
LOOK_EVERY = 0.1  # seconds between looks for the next order
LIFE_EVERY = 2.0  # seconds between looks whether the run goes on
PIECE_SECONDS = 1.0  # of an order that are computed at once: who is to stop, or is not wanted any more, ends after it
PART_SECONDS = 10.0  # after which what came of an order is sent: a kill costs no more, however slow this node is


class Given:
    """The tasks of one order, numbered from 0."""

    def __init__(self, columns: Columns) -> None:
        self._columns = columns

    def __len__(self) -> int:
        return len(self._columns["N"])

    def columns(self, ids: Ids) -> dict[str, NDArray[np.generic]]:
        return {name: values[ids] for name, values in self._columns.items()}

    def find(self, columns: Columns) -> Ids:
        raise NotImplementedError("nobody looks for a task in an order")


def join(comm: Any | None, path: Path) -> int:
    """Every rank is a guest of its own; the exit status. InputError on rank 0 (others return BAD_INPUT)."""
    job = of_rank_0(comm, lambda: _job_of(path))
    if job is None:
        return BAD_INPUT
    compile_once(comm, job)
    return _serve(path, job, loud=comm is None or comm.rank == 0)


def _job_of(path: Path) -> Job:
    """What a table's run computes; InputError where nobody can join it."""
    from sweep.store.reuse import accuracy_of  # pydantic
    from sweep.tell.audit import its_model

    with table.reading(path) as file:
        resolved, kernel, layout = table.resolved(file), _kernel_of_run(file), file[RESULTS].dtype
        first = file[RESULTS][:1]
        if searched.is_searched(resolved):
            raise InputError(f"{path}: is a search, which nobody can join: what it computes follows from its results")
        accuracy = accuracy_of(file)
        model = its_model(file) if resolved.get("model") else None
    if kernel != source_hash():
        raise InputError(f"{path}: is computed by another version of the kernel; join with the run's own")
    if Watched(mailbox.folder_of(path) / mailbox.RUN).is_gone():
        if is_held(path):
            raise InputError(f"{path}: its run is still starting (it may be compiling); try again in a minute")
        raise InputError(f"{path}: no run of it is going on, as this node sees it; start or resume one by `sweep run`")
    tasks = Given({name: first[name] for name in inputs_of(layout)})
    asked = quantities_of(layout), axes_of(layout), model
    return Job(tasks, accuracy.integrator(), accuracy.certify, False, *asked)


def _kernel_of_run(file: h5py.File) -> str:
    """The hash of the kernel that computes now: with --keep-rows others may have computed earlier rows."""
    runs = table.runs(file)
    known = [text_of(run["kernel"]) for run in runs if run["writer"] != REUSED and run["kernel"]]  # a merge has none
    return known[-1] if known else table.attributes(file).get("kernel", "")


def _serve(path: Path, job: Job, loud: bool) -> int:
    """Do what the run orders; the exit status."""
    with ExitStack() as stack:
        stopping, waiting = stack.enter_context(stop_on_signal()), Waiting()
        stack.enter_context(Pulse(None)).watch_disk(waiting.seconds)
        sent, is_wanted = _as_guest(path, job, stopping, waiting)
        while is_wanted:
            say("the run has taken this process for dead, and given its tasks to others; it joins again")
            more, is_wanted = _as_guest(path, job, stopping, waiting)
            sent += more
    with table.reading(path) as file:
        done, failed, left = table.counts(file)
    if loud:
        conclude(f"{sent} rows computed here; {done} done, {failed} failed, {left} left; table {path}")
    return status_of(failed, left)


def _as_guest(path: Path, job: Job, stopping: Callable[[], bool], waiting: Waiting) -> tuple[int, bool]:
    """Compute for the run as its guest: how many rows were sent, and whether the run took this guest for dead."""
    folder, ours = mailbox.folder_of(path), lease.new()
    try:
        if (folder / BITS).exists():
            (folder / f"{ours.token}.{BITS}").write_text(job.numerics_of_first())
        (folder / f"{ours.token}.{KIND}").write_text(compiled_for())
        sign = Sign(folder / f"{ours.token}{GUEST}", ours)
    except FileNotFoundError:  # the run has just ended
        return 0, False
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror}), so nobody can join from here") from None
    patience = Patience(folder, ours.token, stopping, waiting)
    try:
        return _work(folder / ours.token, job, stopping, patience), patience.was_dismissed
    finally:
        sign.close()


def _work(name: Path, job: Job, stopping: Callable[[], bool], patience: "Patience") -> int:
    """Until the run ends, or this process is to stop; how many rows it has sent."""
    sent, number, pieces = 0, 0, Pieces()
    while not stopping():
        try:
            order = patience.until(partial(mailbox.get, name.with_name(f"{name.name}.{number}{ORDER}")))
        except DamagedError as error:
            say(f"{error}; this process ends, and the run gives its tasks to others")
            break
        if order is None:
            break
        for rows in _parts(job, order, pieces, patience):
            sent += patience.until(partial(_put, name.with_name(f"{name.name}.{number}{ROWS}"), rows)) or 0
        number += 1
    return sent


def _put(path: Path, rows: NDArray[np.void]) -> int | None:
    """Send a part of an order's rows, once the run has taken the part before."""
    return None if path.exists() else mailbox.put(path, rows)


class Patience:
    """Tries again until something comes, the run has ended, or this process is to stop.

    A disk that does not answer may do so again; if it does not, the run's sign of life is missed.
    """

    def __init__(self, folder: Path, name: str, stopping: Callable[[], bool], waiting: Waiting) -> None:
        self._folder, self._name, self._stopping, self._waiting = folder, name, stopping, waiting
        self._run, self._looked = Watched(folder / mailbox.RUN), time.monotonic()
        self.is_over = self.was_dismissed = False  # nobody waits for this process any more

    def until(self, act: Callable[[], T | None]) -> T | None:
        """What `act` returns once it returns something; None where the run ends before. It is tried at least once."""
        while True:
            with contextlib.suppress(OSError), self._waiting.counted():
                if (found := act()) is not None:
                    return found
            if self.has_ended():
                return None
            time.sleep(LOOK_EVERY)

    def has_ended(self) -> bool:
        """Whether this process is to stop, or nobody waits for it any more, which is looked at now and then."""
        if self.is_over or self._stopping():
            return True
        if time.monotonic() - self._looked >= LIFE_EVERY:
            self._look()
        return self.is_over

    def _look(self) -> None:
        with self._waiting.counted():
            gone, there = self._run.is_gone(), os.path.exists
            if gone and there(self._folder / mailbox.RUN):
                say("the run has died; `sweep run` goes on with the table")
            self.was_dismissed = (
                not gone and there(self._folder / mailbox.RUN) and not there(self._folder / f"{self._name}{GUEST}")
            )
        self._looked = time.monotonic()
        self.is_over = gone or self.was_dismissed


class Pieces:
    """How many tasks are computed at once, as those before took."""

    def __init__(self) -> None:
        self.tasks = 1

    def took(self, seconds: float) -> None:
        """The last piece took so long."""
        self.tasks = max(1, min(2 * self.tasks, int(self.tasks * PIECE_SECONDS / max(seconds, 1e-6))))


def _parts(job: Job, order: NDArray[np.void], pieces: Pieces, patience: Patience) -> Iterator[NDArray[np.void]]:
    """The finished rows of an order, in its order: all, or the first ones where this process is to end before."""
    columns = {name: np.ascontiguousarray(order[name]) for name in order.dtype.names or () if name != "rank"}
    job, done, since = replace(job, tasks=Given(columns)), 0, time.monotonic()
    rows = list[NDArray[np.void]]()
    while done < len(order) and not patience.has_ended():
        start, ids = time.monotonic(), np.arange(done, min(done + pieces.tasks, len(order)))
        rows.append(compute_rows(job, ids, int(order["rank"][0])))
        done += len(ids)
        pieces.took(time.monotonic() - start)
        if time.monotonic() - since >= PART_SECONDS:
            yield np.concatenate(rows)
            rows, since = [], time.monotonic()
    if rows and not patience.is_over:
        yield np.concatenate(rows)
