"""`sweep run`: check everything, create or resume the table, compute, tell how it ended."""

import json
import os
import platform
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kernel.jit import source_hash
from sweep import provenance, table, writers
from sweep.batches import Batches
from sweep.cost import predict_work, seconds_per_work
from sweep.errors import InputError
from sweep.join import reusable, reuse
from sweep.lock import only_run
from sweep.master import Master
from sweep.progress import Progress, new_run, say
from sweep.schema import RUN
from sweep.shard import Shard, share
from sweep.signals import leave_it_to_the_master, stop_on_signal
from sweep.tasks import TaskList, Tasks
from sweep.worker import Job, OwnWorker, work

ALL_DONE, SOME_FAILED, BAD_INPUT, STOPPED_EARLY = 0, 1, 2, 75
EXIT_STATUS = (
    "exit status: 0 all rows done; 1 some rows failed; 2 bad input or environment; 75 stopped early, run again"
)
SLOW_START = 5.0  # seconds of timing the kernel that only compiling it explains


@dataclass(frozen=True)
class Prepared:
    """What rank 0 has checked and every rank must know."""

    job: Job
    path: Path
    writer: str
    why: str


@dataclass(frozen=True)
class Options:
    """What the user asked for."""

    spec: Path
    table: Path
    writer: str = "auto"
    keep_rows: bool = False
    recompute: bool = False
    shard: Shard | None = None
    reuse: tuple[Path, ...] = ()


def run(comm: Any | None, options: Options) -> int:
    """Compute what is left of the table; the exit status. InputError on rank 0 (others return BAD_INPUT)."""
    if comm is not None and comm.rank > 0:
        leave_it_to_the_master()
        return _worker(comm)
    with ExitStack() as stack:
        stopping = stack.enter_context(stop_on_signal())
        prepared, problem = None, None
        try:
            prepared = _prepare(comm, options, stack)
        except InputError as error:
            problem = error
        if comm is not None:
            comm.bcast(prepared)
        if problem is not None:
            raise problem
        assert prepared is not None
        try:
            return _master(comm, prepared, stopping)
        except InputError as error:  # the table has gone
            if comm is not None:  # the workers wait
                say(str(error))
                comm.Abort(BAD_INPUT)
            raise


def _prepare(comm: Any | None, options: Options, stack: ExitStack) -> Prepared:
    """Everything that can be refused, before anything is computed; holds the table's lock in `stack`."""
    from sweep.spec import read_spec  # pydantic is rank 0's business

    spec, text = read_spec(options.spec)
    tasks = _tasks(spec, options.shard)
    writer, why = writers.choose(options.writer, 1 if comm is None else comm.size)
    path = options.table
    try:
        is_directory = path.is_dir()
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    if is_directory:
        raise InputError(f"{path}: is a directory; -o must name a file")
    reusable(options.reuse, spec.accuracy.model_dump(mode="json"))
    stack.enter_context(only_run(path))
    if not path.exists() or _starts_again(path, spec.differences, options):
        known = provenance.collect(text, spec.resolved(), options.spec.resolve().parent, _mpi_version(comm))
        known |= {"shard": str(options.shard)} if options.shard else {}
        try:
            table.create(path, tasks, known)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    for old in options.reuse:
        say(f"{reuse(path, tasks, old)} rows taken from {old}")
    return Prepared(Job(tasks, spec.accuracy.integrator(), spec.accuracy.certify), path, writer, why)


def _tasks(spec: Any, shard: Shard | None) -> TaskList:
    grid = Tasks(spec.grid.model_dump())
    if shard is None:
        return grid
    work = predict_work(grid.columns(np.arange(len(grid))), spec.accuracy.integrator(), spec.accuracy.certify)
    return share(grid, work, shard)


def _starts_again(path: Path, differences: Any, options: Options) -> bool:
    """Whether the table is to be replaced: no, unless the user asked for it and the kernel has changed.

    Refuses a table of another spec, of another kernel, or one that cannot be written.
    """
    with table.reading(path) as file:
        known, kernels = table.attributes(file), table.kernels(file)
    if differ := differences(json.loads(known["resolved"])):
        raise InputError(f"{path}: holds another sweep (it differs in {', '.join(differ)}); give another -o")
    if (theirs := known.get("shard", "all")) != (ours := str(options.shard or "all")):
        raise InputError(f"{path}: holds another shard of this sweep ({theirs}, not {ours}); give another -o")
    if not os.access(path, os.W_OK):
        raise InputError(f"{path}: cannot be written: no write permission")
    if kernels != {source_hash()} and not options.keep_rows and not options.recompute:
        raise InputError(
            f"{path}: was computed by another version of the kernel (sweep show tells which); give another -o, "
            "or --keep-rows to keep its finished rows all the same, or --recompute to throw them away"
        )
    return options.recompute and kernels != {source_hash()}


def _mpi_version(comm: Any | None) -> str:
    if comm is None:
        return "none (one process)"
    from mpi4py import MPI

    return str(MPI.Get_library_version().splitlines()[0].strip("\0"))


def _open_writer(prepared: Prepared, comm: Any | None) -> writers.Writer:
    if prepared.writer == "mpio":
        return writers.Mpio(prepared.path, comm)
    return writers.Gather(prepared.path)


def _worker(comm: Any) -> int:
    prepared: Prepared | None = comm.bcast(None)
    if prepared is None:
        return BAD_INPUT
    comm.gather(platform.node())
    comm.Barrier()  # rank 0 compiles the kernel, the others find it in the cache
    writer = _open_writer(prepared, comm) if prepared.writer == "mpio" else None
    work(comm, prepared.job, writer)
    if writer is not None:
        writer.close()
    return int(comm.bcast(None))


def _master(comm: Any | None, prepared: Prepared, stopping: Callable[[], bool]) -> int:
    started, job, ranks = time.monotonic(), prepared.job, 1 if comm is None else comm.size
    hosts = [platform.node()] if comm is None else comm.gather(platform.node())
    unit = seconds_per_work()
    compiled = time.monotonic() - started
    if compiled > SLOW_START:
        say(f"compiled the kernel in {compiled:.0f} s; the next run finds it in the cache")
    if comm is not None:
        comm.Barrier()
    with table.reading(prepared.path) as file:
        left, slot = np.flatnonzero(~table.finished(file)), len(table.runs(file))
    work_left = unit * predict_work(job.tasks.columns(left), job.integrator, job.certify)
    batches = Batches(left, work_left, ranks)
    say(
        f"{len(job.tasks)} tasks, {len(left)} left; {ranks} rank{'s' * (ranks > 1)}, rank 0 computes too; "
        f"writer {prepared.writer} ({prepared.why}); {job.integrator}; predicted {batches.seconds_left / ranks:.0f} s"
    )
    writer, own = _open_writer(prepared, comm), OwnWorker(job)
    master = Master(comm, batches, own, writer, prepared.writer == "gather", stopping)
    where = provenance.told_hosts(hosts, RUN["hosts"].itemsize), provenance.slurm_job(os.environ)
    record = new_run(len(left), batches.seconds_left, ranks, prepared.writer, source_hash(), *where)
    progress = Progress(writer, min(slot, table.RUNS_MAX - 1), batches, master.count, record)
    master.run(progress.tick)
    progress.end()
    own.close()
    writer.close()
    status = _tell(prepared.path, time.monotonic() - started)
    if comm is not None:
        comm.bcast(status)
    return status


def _tell(path: Path, seconds: float) -> int:
    """Print how the run ended; the exit status."""
    with table.reading(path) as file:
        done, failed, left = table.counts(file)
    with suppress(OSError):  # a full disk under the log does not change how the run ended
        print(f"{done} done, {failed} failed, {left} left; wall time {seconds:.1f} s; table {path}", flush=True)
    if left:
        return STOPPED_EARLY
    return SOME_FAILED if failed else ALL_DONE
