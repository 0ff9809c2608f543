"""Some rows of a grid that is too large for memory: those with the values that `--at` fixes."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.errors import InputError
from analysis.plane import check_names, missing, same
from analysis.reading import frame_of, torn_rows
from analysis.streamed import ROWS_MAX
from sweep.plan.tasks import Tasks
from sweep.schema import PENDING, RESULTS, today
from sweep.store.table import reading, written
from sweep.store.unwritten import is_unwritten, pending


def rows_at(path: Path, grid: Tasks, at: Mapping[str, float]) -> pd.DataFrame:
    """All rows with these values, as `analysis.load(path, done_only=False)` has them.

    InputError where the grid has no such value, or where more than ROWS_MAX rows have these.
    """
    check_names(list(at), list(grid.axes))
    places = {name: np.flatnonzero(same(grid.axes[name], value)) for name, value in at.items()}
    if problems := [
        missing(grid.axes[name], name, at[name], "task") for name, found in places.items() if not len(found)
    ]:
        raise InputError(*problems)
    count = math.prod(len(places.get(name, axis)) for name, axis in grid.axes.items())
    if count > ROWS_MAX:  # before a number is made for each of them
        some = f"{count} of its {len(grid)} rows" if at else f"its {len(grid)} rows"
        raise InputError(f"{path}: {some} are more than the {ROWS_MAX} that are read at once: fix parameters by --at")
    ids = grid.product(places)
    rows = _rows(path, grid, ids)
    claimed = rows["status"] != PENDING
    torn = torn_rows(rows, claimed)
    return frame_of(rows, np.ones(len(rows), bool), torn, claimed & ~torn).set_index(pd.Index(ids, name="task"))


def _rows(path: Path, grid: Tasks, ids: NDArray[np.int64]) -> NDArray[np.void]:
    with reading(path) as file:
        rows = pending(grid.columns(ids), today(file[RESULTS].dtype))
        for part, some in written(file):
            here = slice(*np.searchsorted(ids, (part.start, part.stop)))
            found = some[ids[here] - part.start]
            there = ~is_unwritten(found)
            rows[here][there] = found[there]
    return rows
