"""The table of a search for the impact that survives: one row for each candidate, in place of its neighbours' rows."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from analysis.errors import InputError
from analysis.quantity import Quantity
from analysis.searched import spec_of
from analysis.table import DONE_LABEL, checked, flagged
from sweep.plan.asked import NEAR, REDUCE, section_of
from sweep.plan.lowest import blocks
from sweep.plan.spec import read_axes


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
    resolved = spec_of(path)
    try:
        section, axes = section_of(resolved), read_axes(resolved.get("grid"))
        tasks = section.every(axes) if section else None
        over, by = resolved["search"]["over"], REDUCE[resolved["search"]["by"]]
    except (ValueError, KeyError, TypeError):
        tasks = None
    if tasks is None or len(tasks) != len(table):
        raise InputError(f"{path}: its provenance does not tell its search")
    ids = blocks(tasks, over, NEAR)
    ids = ids.reshape(-1, ids.shape[-1])
    done = (table["status"].astype(str) == DONE_LABEL).to_numpy()
    ids = ids[done[ids].all(axis=1)]
    rows = table.iloc[ids[:, 0]].copy()
    ratio, error = (table[name].to_numpy(float, na_value=np.nan)[ids] for name in (of.ratio, of.error))
    rows[here(of)], rows[of.ratio], rows[of.error] = ratio[:, 0], by(ratio, axis=1), error.max(axis=1)
    chaotic, known = flagged(table)[ids].any(axis=1), checked(table)[ids].all(axis=1)
    rows["chaotic"], rows["checked"] = pd.Series(chaotic, rows.index, "boolean"), pd.Series(known, rows.index)
    return rows.drop(columns=[name for name in of.spread if name in rows])
