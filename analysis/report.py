"""What a command prints: which rows it used, and the headline numbers."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.best import CELL
from analysis.notes import Notes
from analysis.table import checked, finished, flagged, looked_for_chaos, status_counts, unchecked_told


def rows_used(table: pd.DataFrame, used: pd.DataFrame, cells: pd.DataFrame, told: Notes) -> list[str]:
    """How many rows were used and why the others were not.

    `table` holds all rows, `used` those that competed for a cell, `cells` the ones that are drawn, `told` what the
    picture says of them.
    """
    done = finished(table)
    no_ratio = int((~np.isfinite(done["ke_ratio"])).sum())
    left_out = [f"{no_ratio} without a ke_ratio"]
    if looked_for_chaos(done):
        left_out.append(f"{len(done) - no_ratio - len(used)} chaotic in cells that have other rows")
    return [
        f"rows      {len(table)}: {status_counts(table['status'])}",
        f"used      {len(used)} finished rows; left out: {', '.join(left_out)}",
        f"cells     {_filled(cells, CELL, told.absent)}; {_chaos(cells, told.hatched)}",
    ]


def rows_told(table: pd.DataFrame, used: str) -> list[str]:
    """What the table holds, and what of it was used."""
    return [f"rows      {len(table)}: {status_counts(table['status'])}", f"used      {used}"]


def plane_used(table: pd.DataFrame, cells: pd.DataFrame, over: Sequence[str], told: Notes) -> list[str]:
    """The same for a plane of the grid, from which nothing is left out but the unfinished."""
    return [
        f"rows      {len(table)}: {status_counts(table['status'])}",
        f"cells     {_filled(cells, over, told.absent)}; {_chaos(cells, told.hatched)}",
    ]


def _chaos(cells: pd.DataFrame, hatched: str) -> str:
    """Which cells are hatched, and how many nobody looked at; where nobody looked at any, none is said to be calm."""
    shown = cells[cells["ke_ratio"].notna()]
    told = f"hatched: {hatched or 'none'}" if hatched or looked_for_chaos(shown) else ""
    return "; ".join(filter(None, (told, unchecked_told(shown))))


def lowest(cells: pd.DataFrame) -> list[str]:
    """The lowest ke_ratio of the cells and where it is; a chaotic one only if there is no other.

    Chaotic cells that go lower are told before it.
    """
    lines = []
    chaotic, firm = cells[flagged(cells)], cells[~flagged(cells)]
    if firm["ke_ratio"].notna().any():
        top = _lowest(firm)
        lower = chaotic[chaotic["ke_ratio"] < top["ke_ratio"].iloc[0]]
        if len(lower):
            lines.append(f"chaotic   {len(lower)} cells are lower, down to {_told(_lowest(lower))}")
        return [*lines, f"lowest    {_told(top)}"]
    return [f"lowest    {_told(_lowest(chaotic))} (chaotic: sensitive to its inputs)"]


def _filled(cells: pd.DataFrame, over: Sequence[str], absent: pd.DataFrame | None) -> str:
    places = pd.concat([cells[list(over)], *([] if absent is None else [absent[list(over)]])])
    grid = places[over[0]].nunique() * places[over[1]].nunique()
    return f"{cells['ke_ratio'].notna().sum()} of {grid} have a number"


def _lowest(cells: pd.DataFrame) -> pd.DataFrame:
    """One row: the first of equals in the order of the cells."""
    top = int(np.nanargmin(cells["ke_ratio"].to_numpy(float)))
    return cells.iloc[top : top + 1]


def _told(one: pd.DataFrame) -> str:
    row = one.iloc[0]
    known = [f"estimated error {row['error']:.1g} relative" if np.isfinite(row["error"]) else "error not estimated"]
    known += ["not checked for chaos"] if not checked(one)[0] else []
    return (
        f"ke_ratio = {row['ke_ratio']:.4g} ({', '.join(known)}) at N = {row['N']}, "
        f"zeta_T = {row['zeta_T']:.4g}, M/M0 = {row['M_over_M0']:.4g}, V/V0 = {row['V_over_V0']:.4g}"
    )
