"""ke_ratio over two of the four parameters, the other two fixed (the paper's figures 4 and 5)."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from analysis.errors import InputError
from analysis.table import finished, require, with_spread
from sweep.schema import PARAMETERS

COLUMNS = [*PARAMETERS, "ke_ratio", "error", "chaotic"]
RELATIVE_MATCH = 1e-9  # a value typed from a list of the table's values is that value
_LISTED = 8  # values that a message lists


def map_over(
    df: pd.DataFrame, over: Sequence[str] = ("N", "zeta_T"), at: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """ke_ratio as a matrix: a column per value of `over[0]`, a row per value of `over[1]`, ascending.

    NaN where the table has no finished row. Arguments, choice of rows and errors are those of `plane`.
    """
    return matrix(plane(df, over, at), over, "ke_ratio")


def plane(
    df: pd.DataFrame, over: Sequence[str] = ("N", "zeta_T"), at: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """The finished rows of one plane of the grid, one per cell (the paper's figures 4 and 5).

    `over` names two of N, zeta_T, M_over_M0, V_over_V0; `at` fixes the others at values of the table. One
    that is not in `at` must have a single value among the rows. Columns: the parameters, ke_ratio, `error`
    (estimated, relative), `chaotic`, and spread_low and spread_high where the table has them; sorted by
    `over`; the index is that of `df` (the task). Where a cell was computed more than once, the row with the
    smallest error stands for it, of equals the first task.

    Raises InputError for unknown names, a value that the table does not have (to 1e-9 relative; the
    message lists what there is), a parameter left open, missing columns, and no finished row.
    """
    fixed = dict(at or {})
    _check_names(over, fixed)
    require(df, tuple(COLUMNS))
    done = finished(df)
    rows: pd.DataFrame = done[done[list(PARAMETERS)].notna().all(axis=1)]
    if rows.empty:
        raise InputError("there is no finished row")
    for name, value in fixed.items():
        rows = rows[_matches(rows, name, value)]
    _check_single(rows, [name for name in PARAMETERS if name not in over and name not in fixed])
    cells = rows[with_spread(rows, COLUMNS)].sort_index(kind="stable").sort_values([*over, "error"], kind="stable")
    return cells.drop_duplicates(list(over))


def matrix(cells: pd.DataFrame, over: Sequence[str], name: str) -> pd.DataFrame:
    """Column `name` of unique cells as a matrix: `over[0]` across, `over[1]` down, NaN where none."""
    # Not pivot_table: it averages, and drops what is NaN throughout.
    return cells.pivot(index=over[1], columns=over[0], values=name)  # noqa: PD010


def _check_names(over: Sequence[str], fixed: Mapping[str, float]) -> None:
    unknown = [name for name in [*over, *fixed] if name not in PARAMETERS]
    if unknown:
        raise InputError(f"unknown parameters {', '.join(unknown)}; there are {', '.join(PARAMETERS)}")
    if len(over) != 2 or over[0] == over[1]:
        raise InputError(f"a map is over two different parameters, not over {', '.join(over) or 'none'}")
    both = [name for name in fixed if name in over]
    if both:
        raise InputError(f"{', '.join(both)} cannot be fixed: the map is over {', '.join(over)}")


def _matches(rows: pd.DataFrame, name: str, value: float) -> "pd.Series[bool]":
    # Relative to the table, not to what was asked: an infinity would be near everything.
    found = (rows[name] - value).abs() <= RELATIVE_MATCH * rows[name].abs()
    if not found.any():
        values = _values(rows, name)
        near = np.sort(values[np.argsort(np.abs(values - value), kind="stable")[:_LISTED]])
        raise InputError(f"no finished row has {name} = {value!r}; {_listing(near, len(values))}")
    return found


def _check_single(rows: pd.DataFrame, names: Sequence[str]) -> None:
    open_ones = {name: _values(rows, name) for name in names}
    told = [
        f"{name} ({_listing(values[:_LISTED], len(values))})" for name, values in open_ones.items() if len(values) > 1
    ]
    if told:
        raise InputError(f"choose a value of {' and of '.join(told)}")


def _values(rows: pd.DataFrame, name: str) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    return np.unique(rows[name].to_numpy(dtype=np.float64))


def _listing(values: "np.ndarray[tuple[int], np.dtype[np.float64]]", total: int) -> str:
    # In full precision, so that a listed value can be given back and matches.
    shown = ", ".join(repr(float(value)).removesuffix(".0") for value in values)
    return f"there is {shown}" if len(values) == total else f"there are {total} values, such as {shown}"
