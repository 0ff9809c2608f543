"""What lies between the computed rows of a search for a map: interpolated as the search did it when it chose them."""

from pathlib import Path

import numpy as np
import pandas as pd

from analysis.checks import model_axes
from analysis.errors import InputError
from analysis.quantity import Quantity
from analysis.searched import spec_of
from analysis.table import DONE_LABEL, flagged
from sweep.plan.asked import section_of
from sweep.plan.mesh import expected, leaves
from sweep.plan.refine import Planes
from sweep.plan.spec import read_axes
from sweep.schema import PARAMETERS

COLUMN = "inferred"  # whether a cell's number was interpolated


def inferred(path: str | Path, table: pd.DataFrame, of: Quantity) -> pd.DataFrame | None:
    """The rows that a search for a map has not computed, with their interpolated ratio; None of any other table.

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
    if planes is None or len(planes.logs) != len(table):
        raise InputError(f"{path}: its provenance does not tell its search")
    done = (table["status"].astype(str) == DONE_LABEL).to_numpy()
    usable = np.where(done & ~flagged(table), table[of.ratio].to_numpy(float, na_value=np.nan), np.nan)
    planes.tell(np.arange(len(table)), usable)
    logs = _interpolated(planes, search["error"])
    wanted = np.flatnonzero(~done & np.isfinite(logs))
    rows = table.iloc[wanted][[*PARAMETERS, *model_axes(table)]].copy()
    rows[of.ratio], rows[of.error], rows[COLUMN] = np.exp(logs[wanted]), np.nan, True
    rows["chaotic"] = pd.Series(pd.NA, rows.index, "boolean")
    return rows.assign(checked=False, status=DONE_LABEL)


def _interpolated(planes: Planes, error: float) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    """Of every task the logarithm of its number, as the corners of the box in which it lies let one expect."""
    logs = np.full(len(planes.logs), np.nan)
    for number in range(len(planes.ids)):

        def known(place: tuple[int, ...], plane: int = number) -> float:
            return planes.log(plane, place)

        for box in leaves(planes.shape, planes.scales, known, error):
            for step in np.ndindex(*(b - a + 1 for a, b in box)):
                place = tuple(a + k for (a, _), k in zip(box, step, strict=True))
                logs[planes.ids[(number, *place)]] = expected(box, place, planes.scales, known)
    return logs
