"""Best of the best: which impact a chain protects from most (the paper's figure 8)."""

import numpy as np
import pandas as pd

from analysis.errors import InputError
from analysis.table import finished, require, with_spread
from sweep.schema import PARAMETERS

CELL = ["N", "zeta_T"]
COLUMNS = ["N", "zeta_T", "ke_ratio", "M_over_M0", "V_over_V0", "error", "chaotic"]


def best(df: pd.DataFrame, *, chaotic_too: bool = False) -> pd.DataFrame:
    """For every (N, zeta_T) the row with the lowest ke_ratio over all impacts (the paper's figure 8).

    One row per cell, sorted by N and zeta_T: N, zeta_T, ke_ratio, the M_over_M0 and V_over_V0 that gave
    it, its `error` (estimated, relative), whether it is `chaotic` and, where the table has them, spread_low
    and spread_high; the index is that of `df` (the task).
    All are dimensionless. Which rows compete is told at `competing`; a cell without one is left out.
    Of equal rows the lightest impactor wins, then the slowest, then the lowest task.

    Raises InputError if columns are missing or no row has a ke_ratio.
    """
    rows = competing(df, chaotic_too=chaotic_too)
    lowest = rows.groupby(CELL)["ke_ratio"].transform("min")
    ties = rows.loc[rows["ke_ratio"] == lowest, with_spread(rows, COLUMNS)].sort_index(kind="stable")
    return ties.sort_values([*CELL, "M_over_M0", "V_over_V0"], kind="stable").drop_duplicates(CELL)


def competing(df: pd.DataFrame, *, chaotic_too: bool = False) -> pd.DataFrame:
    """The rows among which `best` chooses: finished, with a finite ke_ratio.

    The ke_ratio of a chaotic row is not determined by its inputs, and the lowest of many such numbers is
    low by luck. They compete only in cells that have no other row (the result's `chaotic` marks them), or
    everywhere with `chaotic_too`, which is how the paper's own map was made.
    """
    require(df, tuple(COLUMNS))
    done = finished(df)
    rows: pd.DataFrame = done[np.isfinite(done["ke_ratio"]) & done[list(PARAMETERS)].notna().all(axis=1)]
    if rows.empty:
        raise InputError("no finished row has a ke_ratio")
    if chaotic_too or not rows["chaotic"].any():
        return rows
    only_chaotic = rows.groupby(CELL)["chaotic"].transform("min").astype(bool)
    chosen: pd.DataFrame = rows[~rows["chaotic"] | only_chaotic]
    return chosen
