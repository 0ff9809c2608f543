"""`sweep merge`: shards of one sweep, or sweeps that overlap, joined into one table."""

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError, gathered, writing
from sweep.files import as_text, wrong_ending
from sweep.log import say
from sweep.plan.spec import NAME_MAX, differing, read_axes
from sweep.plan.tasks import Listed, TaskList, Tasks, keys_of
from sweep.schema import DONE, RESULTS, RUNS, axes_of, inputs_of, is_asked, is_ended, today
from sweep.store import provenance, searched, table
from sweep.store.join import DisagreementError, lacking
from sweep.store.lock import only_run, real
from sweep.store.runs import new_run

# The parts in which the specs of merged tables may differ.
MAY_DIFFER = ("name", "grid", "points", "tasks", "search", "adaptive")
POINTS = ("distinct", "sha256")  # what a spec's points are known by; a merged list keeps it for what is joined later


@dataclass(frozen=True)
class Source:
    """A table to be merged."""

    path: Path
    known: dict[str, str]
    resolved: dict[str, Any]
    kernels: set[str]
    runs: NDArray[np.void]
    layout: np.dtype[Any]  # of its rows today

    @property
    def grid(self) -> dict[str, Any] | None:
        """The axes of the table; None where its tasks are a list, as those of a merged sweep or a search."""
        return None if searched.is_searched(self.resolved) else self.resolved.get("grid")

    @property
    def is_chosen(self) -> bool:
        """Whether a search has chosen its tasks, or some of them."""
        return searched.is_searched(self.resolved) or table.CHOSEN in self.known

    @property
    def points(self) -> dict[str, Any]:
        """Of which points its tasks are all or some, and how many these are; empty where they are of none."""
        told = self.resolved.get("points") or self.resolved.get("tasks") or {}
        return {name: told[name] for name in POINTS if name in told}

    @property
    def asked(self) -> dict[str, Any]:
        """The parts of the spec besides those that may differ."""
        return {name: part for name, part in self.resolved.items() if name not in MAY_DIFFER}

    def differences(self, other: "Source") -> list[str]:
        """In which keys another table asks for other numbers of its tasks, with what either has there."""
        return [f"{key} {ours} and {theirs}" for key, (ours, theirs) in differing(self.asked, other.asked).items()]


def merge(paths: Sequence[Path], output: Path, keep_rows: bool = False, job: str = "") -> dict[str, Any]:
    """Join tables into `output`, which appears or is replaced only when complete; how many rows came from where.

    `job`: the scheduler's job in which this happens, for the new table's list of runs.
    The rows of an existing `output` are joined too, so that nothing is ever lost. InputError names every table that
    cannot be joined, or the tasks that two tables disagree about.
    """
    if problem := wrong_ending(output):
        raise InputError(problem)
    with only_run(output):
        output = real(output)
        sources = _sources([output, *paths] if output.exists() else paths)
        if output.exists() and (shard := sources[0].known.get("shard")):
            raise InputError(f"{output}: exists and is shard {shard} of a sweep; give another -o")
        if output.exists() and searched.is_searched(sources[0].resolved):
            raise InputError(f"{output}: exists and is a search, which could not go on; give another -o")
        _check_alike(sources, keep_rows)
        tasks, resolved, lacking = _union(sources)
        origins = list[dict[str, Any]]()

        def fill(file: h5py.File) -> None:
            origins.extend(_put_all(file, tasks, sources))
            file[RUNS][:] = _runs(file, sources, job)

        with writing(output):
            table.create(output, tasks, _provenance(sources, resolved, tasks), fill, sources[0].layout)
    with table.reading(output) as file:
        done, failed, left = table.counts(file)
    if lacking:
        told = f"{output}: lacks {lacking} tasks, whose rows are damaged or in none of the tables"
        say(f"{told}; complete those, and merge again")
    kind = "grid" if "grid" in resolved else "list"
    counts = {"tasks": len(tasks) + lacking, "done": done, "failed": failed, "left": left + lacking}
    return {"table": str(output), "kind": kind, **counts, "sources": origins}


def _sources(paths: Sequence[Path]) -> list[Source]:
    distinct = dict[str, Path]()
    for path in paths:
        distinct.setdefault(os.path.realpath(path), path)
    return gathered(*(partial(_source, path) for path in distinct.values()))


def _source(path: Path) -> Source:
    with table.reading(path) as file:
        known = table.attributes(file)
        resolved = table.resolved(file)
        try:
            if "grid" in resolved:
                read_axes(resolved["grid"])
        except ValueError:
            raise InputError(f"{path}: its provenance tells no grid") from None
        layout = today(file[RESULTS].dtype)
        return Source(path, known, resolved, table.kernels(file), table.runs(file), layout)


def _check_alike(sources: Sequence[Source], keep_rows: bool) -> None:
    first, problems = sources[0], list[str]()
    for other in sources[1:]:
        if axes_of(other.layout) != axes_of(first.layout):
            ours, theirs = (", ".join(axes_of(source.layout)) or "none" for source in (first, other))
            problems.append(f"{other.path}: varies other numbers of the model than {first.path} ({theirs}, not {ours})")
        elif differ := first.differences(other):
            told = ", ".join(differ)
            problems.append(f"{other.path}: asks for other numbers than {first.path} ({told}); cannot be joined")
    if not keep_rows and len(set().union(*(source.kernels for source in sources))) > 1:
        found = "; ".join(f"{source.path} by {', '.join(sorted(source.kernels))}" for source in sources)
        problems.append(
            f"computed by several versions of the kernel: {found}; recompute, or --keep-rows to join all the same"
        )
    if problems:
        raise InputError(*problems)


def _union(sources: Sequence[Source]) -> tuple[TaskList, dict[str, Any], int]:
    """All tasks of all tables, as a grid where they form one, the spec that asks for them, and how many are lacking."""
    titles = list(dict.fromkeys(str(source.resolved.get("name")) for source in sources))
    resolved: dict[str, Any] = {"name": " + ".join(titles)[:NAME_MAX]}
    grids = [source.grid for source in sources]
    if grids[0] is not None and all(grid == grids[0] for grid in grids):
        return Tasks(grids[0]), resolved | {"grid": grids[0]} | sources[0].asked, 0
    names = inputs_of(sources[0].layout)
    keys, torn = zip(*map(_keys, sources), strict=True)
    listed = Listed(np.concatenate(keys), names)
    points = sources[0].points if all(source.points == sources[0].points for source in sources) else {}
    lacking = max(0, points["distinct"] - len(listed)) if points else sum(torn)
    every = listed.columns(np.arange(len(listed)))
    axes = {name: np.unique(every[name]).tolist() for name in names}
    if len(grid := Tasks(axes)) == len(listed):
        return grid, resolved | {"grid": axes} | sources[0].asked, lacking
    return listed, resolved | {"tasks": {"listed": len(listed), **points}} | sources[0].asked, lacking


def _is_chosen(sources: Sequence[Source], tasks: TaskList) -> bool:
    """Whether a search has chosen some of all these tasks: the others that it left out are in no table."""
    whole = [source for source in sources if not source.is_chosen]
    if not whole or len(whole) == len(sources):
        return not whole
    names = inputs_of(sources[0].layout)
    return len(Listed(np.concatenate([_keys(source)[0] for source in whole]), names)) < len(tasks)


def _keys(source: Source) -> tuple[NDArray[np.void], int]:
    """The key of every task, and how many torn rows are left out: without axes a table has its tasks in its rows."""
    if (grid := source.grid) is not None:
        tasks = Tasks(grid)
        return keys_of(tasks.columns(np.arange(len(tasks)))), 0
    with table.reading(source.path) as file:
        rows = file[RESULTS][()]
        asked = is_asked(rows) | is_ended(rows)
        torn = int(np.count_nonzero(~asked))
        if searched.is_searched(source.resolved):
            left = searched.left(file)[0]
            asked[left[left < len(rows)]] = True  # what is still to be screened is no row
            torn = 0  # it asks for those that it needs
    return keys_of({name: rows[name][asked] for name in inputs_of(source.layout)}), torn


def _put_all(file: h5py.File, tasks: TaskList, sources: Sequence[Source]) -> list[dict[str, Any]]:
    """Put the rows of every source into the new table; of each source how many rows it had, and how many it gave."""
    answer = list[dict[str, Any]]()
    origin = np.zeros(len(tasks), np.int32)
    for number, source in enumerate(sources):
        taken, done, failed = 0, 0, 0
        with table.reading(source.path) as its:
            for rows in table.finished_rows(its):
                try:
                    ids, new = lacking(file, tasks, rows)
                except DisagreementError as error:
                    pairs = zip((sources[k].path for k in origin[error.ids]), error.lines(), strict=False)
                    raise InputError(*(f"{a}, {source.path} disagree: {line}" for a, line in pairs)) from None
                if len(ids):
                    table.write_rows(file[RESULTS], ids, new)
                origin[ids] = number
                taken, good = taken + len(ids), int(np.count_nonzero(rows["status"] == DONE))
                done, failed = done + good, failed + len(rows) - good
        answer.append({"table": str(source.path), "done": done, "failed": failed, "taken": taken})
    return answer


def _runs(file: h5py.File, sources: Sequence[Source], job: str) -> NDArray[np.void]:
    """The list of runs: every run of every source once, the oldest first, then this merge."""
    left = table.counts(file)[2]
    merged = new_run(left, "merge", "", platform.node(), job)
    merged["ended"] = True
    earlier = np.unique(np.concatenate([source.runs for source in sources]))
    earlier = earlier[np.argsort(earlier["start"], kind="stable")]
    log = np.zeros(table.RUNS_MAX, merged.dtype)
    kept = np.concatenate([earlier[-(table.RUNS_MAX - 1) :], merged])
    log[: len(kept)] = kept
    return log


def _provenance(sources: Sequence[Source], resolved: dict[str, Any], tasks: TaskList) -> dict[str, str]:
    """The provenance of the first table, with the specs of all, and under `merged` where each table came from."""
    specs = {source.known.get("spec", ""): source.path for source in reversed(sources)}
    texts = [f"# {as_text(path)}\n{text}" if len(specs) > 1 else text for text, path in reversed(specs.items())]
    known = sources[0].known | {"spec": "\n".join(texts), "resolved": json.dumps(resolved, indent=1)}
    for name in ("shard", table.CHOSEN):
        known.pop(name, None)
    known |= {table.CHOSEN: "by a search"} if _is_chosen(sources, tasks) else {}
    return known | {"merged": json.dumps([_origin(source) for source in sources])}


def _origin(source: Source) -> dict[str, Any]:
    """Where a table came from, without its spec's text; of a merged table, where its parts came from."""
    short = {name: text for name, text in source.known.items() if name not in ("spec", "resolved")}
    return {"table": as_text(source.path), "name": source.resolved.get("name"), **provenance.read(short)}
