"""What a command prints: which rows it used, and the headline numbers."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.best import CELL, lowest_row
from analysis.notes import NO_NOTES, Notes, count, known_told
from analysis.quantity import Quantity
from analysis.table import finished, flagged, looked_for_chaos, status_counts, unchecked_told


def rows_used(table: pd.DataFrame, used: pd.DataFrame, cells: pd.DataFrame, told: Notes) -> list[str]:
    """How many rows were used and why the others were not.

    `table` holds all rows, `used` those that competed for a cell, `cells` the ones that are drawn, `told` what the
    picture says of them.
    """
    done = finished(table)
    no_ratio = int((~np.isfinite(done[told.of.ratio])).sum())
    left_out = [f"{no_ratio} without a {told.of.ratio}"]
    if looked_for_chaos(done):
        left_out.append(f"{len(done) - no_ratio - len(used)} chaotic in cells that have other rows")
    return [
        _rows(table),
        f"used      {len(used)} finished rows; left out: {', '.join(left_out)}",
        f"cells     {_filled(cells, CELL, told)}; {_chaos(cells, told)}",
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
        f"cells     {_filled(cells, over, told)}; {_chaos(cells, told)}",
    ]


def _chaos(cells: pd.DataFrame, told: Notes) -> str:
    """Which cells are hatched, and how many nobody looked at; where nobody looked at any, none is said to be calm."""
    shown = cells[cells[told.of.ratio].notna()]
    hatched = f"hatched: {told.hatched or 'none'}" if told.hatched or looked_for_chaos(shown) else ""
    return "; ".join(filter(None, (hatched, unchecked_told(shown))))


def lowest(cells: pd.DataFrame, told: Notes = NO_NOTES) -> list[str]:
    """The lowest ratio of the cells and where it is, as analysis.best.lowest_row has it.

    Chaotic cells that go lower are told before it.
    """
    of = told.of
    top = lowest_row(cells, chaotic_too=told.chaotic_too, of=of)
    if flagged(top)[0]:
        return [f"lowest    {_told(top, of)}"]
    lower = cells[flagged(cells) & (cells[of.ratio] < top[of.ratio].iloc[0]).to_numpy()]
    are = f"{count(len(lower), 'cell')} {'is' if len(lower) == 1 else 'are'} lower"
    more = [f"chaotic   {are}, down to {_told(lowest_row(lower, of=of), of)}"] if len(lower) else []
    return [*more, f"lowest    {_told(top, of)}"]


def _filled(cells: pd.DataFrame, over: Sequence[str], told: Notes) -> str:
    places = pd.concat([cells[list(over)], *([] if told.absent is None else [told.absent[list(over)]])])
    grid = places[over[0]].nunique() * places[over[1]].nunique()
    return f"{cells[told.of.ratio].notna().sum()} of {grid} have a number"


def _told(one: pd.DataFrame, of: Quantity) -> str:
    row = one.iloc[0]
    return (
        f"{of.ratio} = {row[of.ratio]:.4g} ({known_told(one, of)}) at N = {row['N']}, "
        f"zeta_T = {row['zeta_T']:.4g}, M/M0 = {row['M_over_M0']:.4g}, V/V0 = {row['V_over_V0']:.4g}"
    )
