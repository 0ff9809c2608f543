"""What a command prints: which rows it used, and the headline numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from analysis.best import CELL
from analysis.table import finished, status_counts


def rows_used(table: pd.DataFrame, used: pd.DataFrame, cells: pd.DataFrame) -> list[str]:
    """How many rows were used and why the others were not.

    `table` holds all rows, `used` those that competed for a cell, `cells` the ones that are drawn.
    """
    done = finished(table)
    no_ratio = int((~np.isfinite(done["ke_ratio"])).sum())
    chaotic = len(done) - no_ratio - len(used)
    only_chaotic = int(cells["chaotic"].sum())
    return [
        f"rows      {len(table)}: {status_counts(table['status'])}",
        f"used      {len(used)} finished rows; left out: {no_ratio} without a ke_ratio, "
        f"{chaotic} chaotic in cells that have other rows",
        f"cells     {_filled(cells, CELL)}; hatched: {only_chaotic} that have chaotic rows only",
    ]


def rows_told(table: pd.DataFrame, used: str) -> list[str]:
    """What the table holds, and what of it was used."""
    return [f"rows      {len(table)}: {status_counts(table['status'])}", f"used      {used}"]


def plane_used(table: pd.DataFrame, cells: pd.DataFrame, over: Sequence[str]) -> list[str]:
    """The same for a plane of the grid, from which nothing is left out but the unfinished."""
    chaotic = int((cells["chaotic"] & cells["ke_ratio"].notna()).sum())
    return [
        f"rows      {len(table)}: {status_counts(table['status'])}",
        f"cells     {_filled(cells, over)}; hatched: {chaotic} chaotic",
    ]


def lowest(cells: pd.DataFrame) -> list[str]:
    """The lowest ke_ratio of the cells and where it is; a chaotic one only if there is no other.

    Chaotic cells that go lower are told before it.
    """
    lines = []
    chaotic = cells[cells["chaotic"]]
    firm = cells[~cells["chaotic"]]
    if firm["ke_ratio"].notna().any():
        top = _lowest(firm)
        lower = chaotic[chaotic["ke_ratio"] < top["ke_ratio"]]
        if len(lower):
            lines.append(f"chaotic   {len(lower)} cells are lower, down to {_told(_lowest(lower))}")
        return [*lines, f"lowest    {_told(top)}"]
    return [f"lowest    {_told(_lowest(chaotic))} (chaotic: not determined by the inputs)"]


def _filled(cells: pd.DataFrame, over: Sequence[str]) -> str:
    grid = cells[over[0]].nunique() * cells[over[1]].nunique()
    return f"{cells['ke_ratio'].notna().sum()} of {grid} have a number"


def _lowest(cells: pd.DataFrame) -> "pd.Series[Any]":
    # The first of equals in the order of the cells.
    return cells.iloc[int(np.nanargmin(cells["ke_ratio"].to_numpy()))]


def _told(row: "pd.Series[Any]") -> str:
    error = f"{row['error']:.1g} relative" if np.isfinite(row["error"]) else "not known"
    return (
        f"ke_ratio = {row['ke_ratio']:.4g} (estimated error {error}) at N = {row['N']}, "
        f"zeta_T = {row['zeta_T']:.4g}, M/M0 = {row['M_over_M0']:.4g}, V/V0 = {row['V_over_V0']:.4g}"
    )
