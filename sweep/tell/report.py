"""What `plan`, `status` and `show` answer, as dictionaries: `sweep.tell.text` prints them, or JSON does."""

import math
import platform
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from sweep.plan.chains import assumptions
from sweep.plan.forecast import Forecast, forecast, predict_asked, with_screening
from sweep.plan.parts import PART
from sweep.plan.search import COMPUTE, SCREEN, TRY
from sweep.plan.spec import Spec
from sweep.plan.speed import seconds_per_work
from sweep.plan.tasks import TaskList, Tasks
from sweep.schema import DONE, RESULTS, REUSED, RUN, text_of
from sweep.store import provenance, searched, table
from sweep.store.lock import is_held
from sweep.store.reuse import reused
from sweep.store.runs import places_of, seconds_to_go

RANKS = (1, 2, 16, 128, 1024)  # for which a plan gives the wall time: from a laptop to a large job
RANK_BYTES = 189_000_000  # memory of a process that computes: `python -m tests.measure`
TASK_BYTES = 170  # further memory on rank 0, at most, for each task that is held, while they are put in order
FLAG_BYTES = 1  # for each other task of a large sweep: whether it is left (python -m tests.large)
EFFICIENCY = ("busy", "work_finished", "busy_share", "least_busy_share", "waited", "waited_cpu", "tail", "serving")


def counted(spec: Spec) -> dict[str, Any]:
    """The part of a plan that needs no prediction."""
    return {
        "name": spec.name,
        **_extent(spec),
        "method": str(spec.accuracy.integrator()),
        "certified": spec.accuracy.certify,
    }


def _extent(spec: Spec) -> dict[str, Any]:
    extent = spec.extent()
    told: dict[str, Any] = {"tasks": extent.first}
    told |= {"at_most": extent.at_most} if spec.asked else {}
    told |= {"screened": extent.at_most} if extent.screens else {}
    return told | ({"tried": extent.at_most} if extent.tries else {})


def plan(spec: Spec, text: str, folder: Path) -> dict[str, Any]:
    """Tasks, predicted cost, memory and table size of a spec. Computes no task; times one small run where the speed of
    this machine is not remembered.

    `spec` and `text` are what `sweep.plan.spec.read_spec` returns, `folder` is where the spec lies. core_hours and
    longest_task_s are the cost model's sum and maximum: over all tasks where `looked_at` is their number, otherwise
    estimated from a sample, with a standard error. `assumed` says in words what of the chain the model does not
    predict. wall_s holds seconds by number of ranks; memory and table are in bytes.
    """
    accuracy, tasks = spec.accuracy, spec.task_list()
    model, quantities = spec.kernel_model(), len(spec.output.quantities())
    extent, unit = spec.extent(), seconds_per_work()
    what = accuracy.integrator(), accuracy.certify, model, quantities, extent.screens

    def of(asked: int) -> Forecast:
        return forecast(tasks, extent.at_most, lambda ids: unit * predict_asked(tasks, ids, asked, *what))

    work, screening = of(COMPUTE), {}
    if extent.tries:
        work = with_screening(work, of(TRY))
    if extent.screens:
        work = with_screening(work, first := of(SCREEN))
        screening = {"screening_core_hours": first.seconds / 3600}
    known = provenance.collect(text, spec.resolved(), folder, "")
    return {
        **counted(spec),
        "core_hours": work.seconds / 3600,
        **screening,
        "core_hours_standard_error": work.standard_error / 3600,
        "looked_at": work.looked_at,
        "longest_task_s": work.longest,
        "assumed": assumptions(model, quantities, spec.varied()),
        "wall_s": {str(k): work.wall(k) for k in RANKS},
        "memory_rank_0": RANK_BYTES + _held(tasks, spec) * TASK_BYTES + len(tasks) * FLAG_BYTES,
        "table_bytes": table.size(len(tasks), known, spec.layout(), extent.screens > 0),
    }


def _held(tasks: TaskList, spec: Spec) -> int:
    """How many tasks rank 0 holds at a time: of a grid a part."""
    return min(len(tasks), PART) if isinstance(tasks, Tasks) and spec.asked is None else len(tasks)


def status(path: Path) -> dict[str, Any]:
    """How far a table is; works while it is being written.

    `running` is None where this host cannot tell, as another host's lock need not be visible here. `certified` is False
    where no row is checked for chaos. In a search `tasks`, `left` and `eta_s` count what it has asked for so far, as
    last recorded; while it runs, `tasks` may be too large by what is computed in a second. Where a search screens,
    `screened` and `tried` are the numbers of tasks that were, and `left` includes those still to be screened or tried.
    """
    held = is_held(path)
    with table.reading(path) as file:
        kinds, left = searched.counts(file, held)
        seen = searched.seen(file)
        runs, shard, resolved = table.runs(file), table.attributes(file).get("shard"), table.resolved(file)
    runs = runs[runs["writer"] != REUSED]
    done, ended = kinds[text_of(DONE)], kinds.total()
    report: dict[str, Any] = {"tasks": ended + left, "done": done, "failed": ended - done, "left": left}
    report |= {"failures": {kind: rows for kind, rows in sorted(kinds.items()) if kind != text_of(DONE)}}
    report |= {} if seen is None else seen._asdict()
    report |= {"certified": resolved.get("accuracy", {}).get("certify"), "search": searched.is_searched(resolved)}
    report |= {"shard": shard} if shard else {}
    report |= {"running": held, "host": None, "updated": None, "rate_per_s": None, "eta_s": None}
    return report | _last_run(runs[-1], report) if len(runs) else report


def _last_run(last: np.void, report: dict[str, Any]) -> dict[str, Any]:
    host, seconds = text_of(last["host"]), float(last["updated"] - last["start"])
    finished = int(last["left_at_start"]) - int(last["left"])  # as old as `updated`, unlike the report's
    elsewhere = not (report["running"] or last["ended"] or host == platform.node()[: RUN["host"].itemsize])
    running = None if elsewhere else report["running"]
    return {
        "running": running,
        "host": host,
        "updated": _utc(last["updated"]),
        "rate_per_s": finished / seconds if finished and seconds > 0 else None,
        "eta_s": seconds_to_go(last) if report["left"] and running is not False else None,
    }


def show(path: Path) -> dict[str, Any]:
    """Provenance: the spec, versions, host, every run with its wall time, what came from other tables.

    `git` is the revision of the folder in which the spec lay, not of the program.
    """
    with table.reading(path) as file:
        known = provenance.read(table.attributes(file))
        known |= {"search": _searched(file)} if searched.is_searched(table.resolved(file)) else {}
        runs = table.runs(file)
    known["reused"] = reused(runs)
    known["runs"] = [_run(row) for row in runs[runs["writer"] != REUSED]]
    known["wall_s"] = math.fsum(run["wall_s"] for run in known["runs"])
    return known


def _searched(file: h5py.File) -> str:
    """What a search has computed of its table."""
    kinds, left = searched.counts(file)
    seen, more = searched.seen(file), f"; {left} more asked for" if left else ""
    looked = "" if seen is None else f", {seen.in_words()}"
    return f"{kinds.total()} of {len(file[RESULTS])} rows computed{looked}{more}"


def _run(row: np.void) -> dict[str, Any]:
    return {
        "start": _utc(row["start"]),
        "wall_s": round(float(row["updated"] - row["start"]), 3),
        "rows": int(row["left_at_start"]) - int(row["left"]),
        "ranks": int(row["ranks"]),
        **({name: round(float(row[name]), 4) for name in EFFICIENCY} if row["ended"] else {}),
        **{name: text_of(row[name]) for name in ("writer", "kernel", "host")},
        **dict(zip(("hosts", "processors"), places_of(text_of(row["hosts"])), strict=True)),
        "job": text_of(row["job"]),
    }


def _utc(instant: np.float64) -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(float(instant)))
