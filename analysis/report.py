"""What a command prints: which rows it used, and the headline numbers."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.best import CELL, lowest_row
from analysis.notes import Notes, count, known_told
from analysis.table import finished, flagged, looked_for_chaos, status_counts, unchecked_told


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
        _rows(table),
        f"used      {len(used)} finished rows; left out: {', '.join(left_out)}",
        f"cells     {_filled(cells, CELL, told.absent)}; {_chaos(cells, told.hatched)}",
    ]


def rows_told(table: pd.DataFrame, used: str) -> list[str]:
    """What the table holds, and what of it was used."""
    return [_rows(table), f"used      {used}"]


def _rows(table: pd.DataFrame) -> str:
    return f"rows      {len(table)}: {status_counts(table['status'])}"


def plane_used(table: pd.DataFrame, cells: pd.DataFrame, over: Sequence[str], told: Notes) -> list[str]:
    """The same for a plane of the grid, from which nothing is left out but the unfinished."""
    return [
        _rows(table),
        f"cells     {_filled(cells, over, told.absent)}; {_chaos(cells, told.hatched)}",
    ]


def _chaos(cells: pd.DataFrame, hatched: str) -> str:
    """Which cells are hatched, and how many nobody looked at; where nobody looked at any, none is said to be calm."""
    shown = cells[cells["ke_ratio"].notna()]
    told = f"hatched: {hatched or 'none'}" if hatched or looked_for_chaos(shown) else ""
    return "; ".join(filter(None, (told, unchecked_told(shown))))


def lowest(cells: pd.DataFrame, chaotic_too: bool = False) -> list[str]:
    """The lowest ke_ratio of the cells and where it is, as analysis.best.lowest_row has it.

    Chaotic cells that go lower are told before it.
    """
    top = lowest_row(cells, chaotic_too=chaotic_too)
    if flagged(top)[0]:
        return [f"lowest    {_told(top)}"]
    lower = cells[flagged(cells) & (cells["ke_ratio"] < top["ke_ratio"].iloc[0]).to_numpy()]
    are = f"{count(len(lower), 'cell')} {'is' if len(lower) == 1 else 'are'} lower"
    more = [f"chaotic   {are}, down to {_told(lowest_row(lower))}"] if len(lower) else []
    return [*more, f"lowest    {_told(top)}"]


def _filled(cells: pd.DataFrame, over: Sequence[str], absent: pd.DataFrame | None) -> str:
    places = pd.concat([cells[list(over)], *([] if absent is None else [absent[list(over)]])])
    grid = places[over[0]].nunique() * places[over[1]].nunique()
    return f"{cells['ke_ratio'].notna().sum()} of {grid} have a number"


def _told(one: pd.DataFrame) -> str:
    row = one.iloc[0]
    return (
        f"ke_ratio = {row['ke_ratio']:.4g} ({known_told(one)}) at N = {row['N']}, "
        f"zeta_T = {row['zeta_T']:.4g}, M/M0 = {row['M_over_M0']:.4g}, V/V0 = {row['V_over_V0']:.4g}"
    )
