"""What a search makes of its rows: a map between the computed ones, or one row for an impact with its neighbours."""

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from analysis.checks import inputs
from analysis.quantity import Quantity
from analysis.searched import screened, search_of, spec_of
from analysis.table import DONE_LABEL, TO_COME, checked, flagged
from sweep.errors import InputError
from sweep.plan.asked import NEAR, REDUCE, Sought, section_of
from sweep.plan.lowest import blocks
from sweep.plan.refine import Planes
from sweep.plan.spec import read_axes
from sweep.plan.tasks import Tasks

CANDIDATE = "A candidate is an impact with those around it."
COLUMN = "inferred"  # whether a cell's number was inferred


def _search(path: str | Path, rows: int) -> tuple[Sought, Tasks]:
    """The search of a table of so many rows, and all its tasks; InputError where its provenance does not tell them."""
    spec = spec_of(path)
    with suppress(ValueError, KeyError, TypeError):
        section, axes = section_of(spec), read_axes(spec.get("grid"))
        if isinstance(section, Sought) and {*(section.over or ())} <= {*axes}:
            tasks = section.every(axes)
            if len(tasks) == rows:
                return section, tasks
    raise InputError(f"{path}: its provenance does not tell its search")


def inferred(path: str | Path, table: pd.DataFrame, of: Quantity) -> pd.DataFrame | None:
    """The rows that a search for a map has not computed, with their inferred ratio; None of any other table.

    As the search did it when it chose what to compute. `table` holds all rows. A place that nothing tells of is left
    out.
    """
    asked = search_of(path) or {}
    if asked.get("find") != "map" or asked.get("of") != of.ratio:
        return None
    search, tasks = _search(path, len(table))
    seen = screened(path) if search.screen else np.ones(len(table))
    if len(seen) != len(table):
        raise InputError(f"{path}: its provenance does not tell its search")
    to_come = table["status"].astype(str).isin(TO_COME).to_numpy()
    done = (table["status"].astype(str) == DONE_LABEL).to_numpy()
    usable = np.where(done & ~flagged(table), table[of.ratio].to_numpy(float, na_value=np.nan), np.nan)
    logs = Planes(tasks, search.over or ()).inferred(usable, seen, ~to_come)
    wanted = np.flatnonzero(to_come & np.isfinite(logs))
    rows = table.iloc[wanted][inputs(table)].copy()
    rows[of.ratio], rows[of.error], rows[COLUMN] = np.exp(logs[wanted]), np.nan, True
    rows["chaotic"] = pd.Series(pd.NA, rows.index, "boolean")
    return rows.assign(checked=False, status=DONE_LABEL)


def here(of: Quantity) -> str:
    """The column of the ratio at the impact itself."""
    return f"{of.ratio}_here"


def words(search: dict[str, Any] | None) -> str:
    """What counts of a candidate, for example "worst within 2 %"; empty where its own number does."""
    return f"{search['by']} within {100 * search['robust']:.3g} %" if search and search.get("robust") else ""


def candidates(path: str | Path, table: pd.DataFrame, of: Quantity) -> pd.DataFrame:
    """One row for each candidate all of whose tasks are done: an impact together with its neighbours.

    `table` holds all rows of the sweep. The ratio is the worst, or the median, over the candidate's impacts, and its
    error the largest of theirs. A candidate is chaotic where one of its rows is. In the column `here` is the ratio of
    the impact itself.
    """
    search, tasks = _search(path, len(table))
    by, ids = REDUCE[search.by or ""], blocks(tasks, search.over or (), NEAR)
    ids = ids.reshape(-1, ids.shape[-1])
    done = (table["status"].astype(str) == DONE_LABEL).to_numpy()
    ids = ids[done[ids].all(axis=1)]
    rows = table.iloc[ids[:, 0]].copy()
    ratio, error = (table[name].to_numpy(float, na_value=np.nan)[ids] for name in (of.ratio, of.error))
    rows[here(of)], rows[of.ratio], rows[of.error] = ratio[:, 0], by(ratio, axis=1), error.max(axis=1)
    chaotic, known = flagged(table)[ids].any(axis=1), checked(table)[ids].all(axis=1)
    rows["chaotic"], rows["checked"] = pd.Series(chaotic, rows.index, "boolean"), pd.Series(known, rows.index)
    return rows.drop(columns=[name for name in of.spread if name in rows])
