"""Rows that form no grid, as a spec's [points] gives them: which are drawn, and how one tells them from a grid."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.checks import inputs, require, require_numbers_of_model
from analysis.plane import check_over
from analysis.quantity import KE, Quantity
from analysis.table import finished, once, with_optional
from sweep.errors import InputError

SPARSE = 4  # a grid has at least one row for so many of its cells


def scattered(df: pd.DataFrame, over: Sequence[str], of: Quantity = KE) -> pd.DataFrame:
    """The finished rows with a ratio, each task once: inputs, ratio, its error, what is known of chaos.

    InputError for unknown names, missing columns, and no such row.
    """
    known = inputs(df)
    check_over(over, known)
    columns = [*known, of.ratio, of.error, "chaotic"]
    require(df, columns)
    done = finished(df)
    require_numbers_of_model(done)
    rows = once(done[done[known].notna().all(axis=1) & np.isfinite(done[of.ratio])], of.ratio)
    if rows.empty:
        raise InputError(f"there is no finished row with a {of.ratio}")
    return rows[with_optional(rows, columns, of)]


def refuse_points(df: pd.DataFrame, over: Sequence[str], several: bool = False) -> None:
    """InputError where the rows are too few for a grid over these two: as a map they would be cells that touch none.

    Rows that are not finished count: a search computes few of its grid, and a run has just begun. `several`: not where
    the places have two rows or more in the mean, of which a picture tells one each, as points could not.
    """
    if len(over) != 2:
        return  # which the map itself refuses
    cells = df[over[0]].nunique() * df[over[1]].nunique()
    if SPARSE * len(df) < cells and not (several and len(df) >= 2 * len(df[list(over)].drop_duplicates())):
        raise InputError(
            f"{len(df)} rows form no grid over {' and '.join(over)} ({df[over[0]].nunique()} times "
            f"{df[over[1]].nunique()} values): `analysis points` draws them where they are"
        )
