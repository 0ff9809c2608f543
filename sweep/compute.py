"""One task to one row: the only place where the sweep calls the kernel."""

import sys
import time
import traceback

import numpy as np
from numpy.typing import NDArray

from kernel.ke import ke_ratio_of
from kernel.method import RK45
from sweep.schema import ROW, seal
from sweep.tasks import Ids, Tasks

FROM_KERNEL = ("ke_bistable", "ke_linear", "ke_ratio", "t_peak_bistable", "t_peak_linear", "error", "chaotic", "steps")


def compute_rows(tasks: Tasks, ids: Ids, integrator: RK45, certify: bool, rank: int) -> NDArray[np.void]:
    """The finished rows of tasks `ids`, sealed, in that order. A task that fails is a row with a status."""
    rows = np.zeros(len(ids), ROW)
    for name, values in tasks.columns(ids).items():
        rows[name] = values
    rows["rank"] = rank
    for row, task_id in zip(rows, ids.tolist(), strict=True):
        _fill(row, tasks, task_id, integrator, certify)
    seal(rows)
    return rows


def _fill(row: np.void, tasks: Tasks, task_id: int, integrator: RK45, certify: bool) -> None:
    start = time.perf_counter()
    row["method"] = integrator.name
    try:
        result = ke_ratio_of(tasks.task(task_id), integrator, certify)
    except Exception:  # a bug in the kernel must cost one row, not the sweep
        sys.stderr.write(f"sweep: task {task_id} raised\n{traceback.format_exc()}")
        row["status"] = "error"
        for name in FROM_KERNEL[:6]:
            row[name] = np.nan
    else:
        row["status"] = result.status
        for name in FROM_KERNEL:
            row[name] = getattr(result, name)
    row["seconds"] = time.perf_counter() - start
