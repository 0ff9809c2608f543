"""Before a run, on rank 0: refuse what cannot work, then create the table or find it fit to resume."""

import os
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from kernel.version import source_hash
from sweep.errors import InputError, gathered, refuse_all, writing
from sweep.files import folder_problem, page_problem, wrong_ending
from sweep.log import say
from sweep.plan.cost import predict_all
from sweep.plan.own import loaded
from sweep.plan.search import Extent, Search
from sweep.plan.shard import Shard, share
from sweep.plan.tasks import TaskList
from sweep.schema import RESULTS, RUNS, is_asked, is_ended, today
from sweep.serve.pulse import Pulse
from sweep.serve.worker import Job
from sweep.site import launch, walltime
from sweep.store import known, provenance, table, writers
from sweep.store.lock import only_run, real
from sweep.store.repair import Rows, rescued
from sweep.store.reuse import reusable, reuse
from sweep.store.searched import mark, mend

if TYPE_CHECKING:
    from sweep.plan.spec import Spec


@dataclass(frozen=True)
class Options:
    """What the user asked for."""

    spec: Path
    table: Path
    writer: str = "auto"
    keep_rows: bool = False
    recompute: bool = False
    shard: Shard | None = None
    reuse: Sequence[Path] = ()
    until: str | None = None
    max_fails: int | None = None
    retry_failed: bool = False
    repair: bool = False
    page: Path | None = None
    store: Path | None = None
    wrong: Sequence[str] = ()  # problems of options that the command line found, told beside all others


@dataclass(frozen=True)
class Prepared:
    """What rank 0 has checked and every rank must know."""

    job: Job
    path: Path
    writer: str
    why: str
    retry_failed: bool = False
    extent: Extent | None = None  # of a search
    deadline: float | None = None  # seconds since 1970
    flush_every: float = 30.0  # seconds
    store: Path | None = None  # where rows of all sweeps are kept
    what: dict[str, Any] = field(default_factory=dict)  # sweep.store.known.of_spec
    sampler: Path | None = None  # the user's own, that steers the search
    is_new: bool = False  # whether there was no table


def prepare(comm: Any | None, options: Options, held: ExitStack, pulse: Pulse) -> Prepared:
    """Check everything, create the table or find it fit to resume; its lock is held in `held`."""
    hosts, place = pulse.hosts, real(options.table).parent
    deadline, (spec, text, search, tasks), (writer, why), *_ = gathered(
        lambda: walltime.deadline(options.until, os.environ, time.time()),
        lambda: _asked(options),
        lambda: writers.choose(options.writer, len(hosts), len(set(hosts)), place),
        lambda: refuse_bad_names(options),
        lambda: refuse_all(options.wrong),
    )
    integrator, certify = spec.accuracy.integrator(), spec.accuracy.certify
    store = known.checked(options.store)
    held.enter_context(only_run(options.table, pulse.give_up))
    path = real(options.table)
    asked = spec.output.quantities(), spec.varied(), spec.kernel_model()
    shown, screens = search is not None or store is not None, search.screens if search else 0.0
    job = Job(tasks, integrator, certify, shown, *asked, screens)
    identity = source_hash(), *spec.identity_texts()
    is_new = not path.exists()
    saved = rescued(path, tasks, identity, job.layout) if options.repair and not is_new else None
    if saved is not None or is_new or _starts_again(path, spec, options):
        origin = provenance.collect(text, spec.resolved(), options.spec.resolve().parent, launch.mpi_version(comm))
        origin |= {"shard": str(options.shard)} if options.shard else {}
        _create(path, job, origin, saved, search)
    else:
        table.clear(path)  # of a merge into it
        if options.shard:
            _refuse_other_tasks(path, tasks)
        _convert(path, tasks)
        mend(path)
    for old in options.reuse:
        say(f"{reuse(path, tasks, old, spec.accuracy)} rows taken from {old}")
    extent = spec.extent() if search else None
    often, what = spec.output.flush_every, known.of_spec(spec)
    sampler = spec.sampler(options.spec.parent)
    return Prepared(job, path, writer, why, options.retry_failed, extent, deadline, often, store, what, sampler, is_new)


def _asked(options: Options) -> "tuple[Spec, str, Search | None, TaskList]":
    """The spec, its text, its search and the tasks of this run; refuses what does not go with the spec."""
    from sweep.plan.spec import read_spec  # pydantic is rank 0's business

    spec, text = read_spec(options.spec)
    search, sampler = spec.new_search(), spec.sampler(options.spec.parent)
    tasks, *_ = gathered(
        lambda: _tasks(spec, options.shard, search is not None),
        lambda: reusable(options.reuse, spec.accuracy, spec.layout(), spec.model),
        lambda: sampler and loaded(sampler),
    )
    return spec, text, search, tasks


def _tasks(spec: "Spec", shard: Shard | None, searches: bool) -> TaskList:
    """All of the spec, or of its shard."""
    grid, accuracy = spec.task_list(), spec.accuracy
    if shard is None:
        return grid
    if searches:
        raise InputError("--shard: a search has no shares: what it computes follows from its results")
    how = accuracy.integrator(), accuracy.certify, spec.kernel_model(), len(spec.output.quantities())
    return share(grid, lambda ids: predict_all(grid, ids, *how), shard)


def refuse_bad_names(options: Options) -> None:
    """InputError where a table or a page cannot have its name, or no folder is there for the table."""
    path, problems = options.table, list[str]()
    with writing(path):
        is_directory = path.is_dir()
    if problem := wrong_ending(path):
        problems.append(problem)
    elif is_directory:
        problems.append(f"{path}: is a directory; -o must name a file")
    elif problem := folder_problem(real(path)):
        problems.append(f"{path}: {problem}")
    for old in options.reuse:
        if os.path.realpath(old) == os.path.realpath(path):
            problems.append(f"--reuse {old}: is the table that is to be written")
    if options.page is not None and (problem := page_problem(options.page, remedy="move it, or give another")):
        problems.append(f"--page: {problem}")
    if problems:
        raise InputError(*problems)


def _create(path: Path, job: Job, known: dict[str, str], saved: Rows | None, search: Search | None) -> None:
    def fill(file: h5py.File) -> None:
        if search:
            mark(search, file)
        if saved is not None and len(saved[0]):
            table.write_rows(file[RESULTS], *saved)

    with writing(path):
        table.create(path, job.tasks, known, fill, job.layout, search is not None and search.screens > 0)


def _convert(path: Path, tasks: TaskList) -> None:
    """Where the table at `path` has an older layout, write it anew in today's.

    Every row, run and text of provenance is kept. The new table takes the old one's place only when complete.
    """
    with table.reading(path) as old:
        if old[RESULTS].dtype == (layout := today(old[RESULTS].dtype)):
            return

        def fill(file: h5py.File) -> None:
            for part, rows in table.chunks(old):
                file[RESULTS][part] = rows
            file[RUNS][...] = old[RUNS][...]

        with writing(path):
            table.create(path, tasks, table.attributes(old), fill, layout)
    say(f"{path}: was written by an earlier version; its rows now say whether they were checked for chaos")


def _refuse_other_tasks(path: Path, tasks: TaskList) -> None:
    """InputError where this shard was dealt other tasks: some would then be in no shard, others in two."""
    with table.reading(path) as file:
        known = len(file[RESULTS]) == len(tasks) and all(_are_of(tasks, *some) for some in table.chunks(file))
    if not known:
        raise InputError(
            f"{path}: holds other tasks than this shard has now: an earlier version has dealt out this shard, or a row "
            f"of it is damaged; give another -o, and --reuse {path} and the tables of the other shards"
        )


def _are_of(tasks: TaskList, part: slice, rows: NDArray[np.void]) -> bool:
    """Whether the rows of this part are of its tasks; a damaged one says nothing."""
    columns = tasks.columns(np.arange(part.start, part.stop))
    others = rows[np.any([rows[name] != values for name, values in columns.items()], axis=0)]
    return not (is_asked(others) | is_ended(others)).any()


def _serves(path: Path, spec: "Spec") -> bool:
    """Whether `--reuse` would take rows of this table for the spec's."""
    try:
        reusable([path], spec.accuracy, spec.layout(), spec.model)
    except InputError:
        return False
    return True


def _starts_again(path: Path, spec: "Spec", options: Options) -> bool:
    """Whether the table is to be replaced: no, unless the user asked for it and the kernel has changed.

    Refuses a table of another spec, of another kernel, or one that cannot be written.
    """
    with table.reading(path) as file:
        known, resolved, kernels = table.attributes(file), table.resolved(file), table.kernels(file)
    if differ := spec.differences(resolved):
        way = f", and --reuse {path} to take over the rows that both have" if _serves(path, spec) else ""
        raise InputError(f"{path}: holds another sweep (it differs in {', '.join(differ)}); give another -o{way}")
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
