"""What lies between the computed rows of a search for a map: inferred as the search did it when it chose them."""

from pathlib import Path

import numpy as np
import pandas as pd

from analysis.checks import inputs
from analysis.errors import InputError
from analysis.quantity import Quantity
from analysis.searched import screened, spec_of
from analysis.table import DONE_LABEL, TO_COME, flagged
from sweep.plan.asked import section_of
from sweep.plan.refine import Planes
from sweep.plan.spec import read_axes

COLUMN = "inferred"  # whether a cell's number was inferred


def inferred(path: str | Path, table: pd.DataFrame, of: Quantity) -> pd.DataFrame | None:
    """The rows that a search for a map has not computed, with their inferred ratio; None of any other table.

    `table` holds all rows. A place that nothing tells of is left out.
    """
    spec = spec_of(path)
    search = spec.get("search") or {}
    if search.get("find") != "map" or search.get("of") != of.ratio:
        return None
    try:
        section, axes = section_of(spec), read_axes(spec.get("grid"))
        planes = Planes(section.every(axes), search["over"]) if section else None
    except (ValueError, KeyError, TypeError):
        planes = None
    seen = screened(path) if search.get("screen") else np.ones(len(table))
    if planes is None or not planes.ids.size == len(seen) == len(table):
        raise InputError(f"{path}: its provenance does not tell its search")
    to_come = table["status"].astype(str).isin(TO_COME).to_numpy()
    done = (table["status"].astype(str) == DONE_LABEL).to_numpy()
    usable = np.where(done & ~flagged(table), table[of.ratio].to_numpy(float, na_value=np.nan), np.nan)
    logs = planes.inferred(usable, seen, ~to_come)
    wanted = np.flatnonzero(to_come & np.isfinite(logs))
    rows = table.iloc[wanted][inputs(table)].copy()
    rows[of.ratio], rows[of.error], rows[COLUMN] = np.exp(logs[wanted]), np.nan, True
    rows["chaotic"] = pd.Series(pd.NA, rows.index, "boolean")
    return rows.assign(checked=False, status=DONE_LABEL)
