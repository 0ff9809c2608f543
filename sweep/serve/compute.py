"""A batch of tasks to rows: the only place where the sweep calls the kernel."""

import sys
import time
import traceback

import numpy as np
from numpy.typing import NDArray

from kernel.ke import RESULT, results_of
from kernel.method import Integrator
from sweep.plan.tasks import Ids, TaskList
from sweep.schema import COLUMNS, PARAMETERS, RAISED, blank_of, seal

FROM_KERNEL = [name for name in RESULT.names or () if name in COLUMNS and name not in PARAMETERS]


def compute_rows(tasks: TaskList, ids: Ids, integrator: Integrator, certify: bool, rank: int) -> NDArray[np.void]:
    """The finished rows of tasks `ids`, sealed, in that order. A task that fails is a row with a status."""
    rows = blank_of(tasks.columns(ids))
    rows["rank"] = rank
    if (trouble := _fill(rows, tasks, ids, integrator, certify)) and len(ids) > 1:
        # A bug in the kernel must cost the rows that it strikes, not the batch.
        troubles = [_fill(rows[i : i + 1], tasks, ids[i : i + 1], integrator, certify) for i in range(len(ids))]
    else:
        troubles = [trouble]
    for task_id, report in zip(ids, troubles, strict=False):
        if report:
            sys.stderr.write(f"sweep: task {task_id} raised\n{report}")
    seal(rows)
    return rows


def _fill(rows: NDArray[np.void], tasks: TaskList, ids: Ids, integrator: Integrator, certify: bool) -> str:
    """Compute the rows; the traceback where the kernel raised.

    A batch's time is shared out by the work that each task was.
    """
    start = time.perf_counter()
    try:
        results = results_of(tasks.columns(ids), integrator, certify)
    except Exception:
        rows["status"] = RAISED
        rows["seconds"] = time.perf_counter() - start
        return traceback.format_exc()
    for name in FROM_KERNEL:
        rows[name] = results[name]
    work = results["site_evaluations"] + 1.0
    rows["seconds"] = (time.perf_counter() - start) * work / work.sum()
    return ""
