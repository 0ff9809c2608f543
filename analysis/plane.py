"""The ratio of a quantity over two of the four parameters, the other two fixed (the paper's figures 4 and 5)."""

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np
import pandas as pd

from analysis.checks import inputs, require
from analysis.quantity import KE, Quantity
from analysis.ruler import RELATIVE_MATCH
from analysis.table import finished, with_optional
from kernel.hints import did_you_mean, exactly, shown
from sweep.errors import InputError, refuse_all
from sweep.schema import PARAMETERS

_VALUES_LISTED = 8  # values that a message lists


def map_over(
    df: pd.DataFrame, over: Sequence[str] = ("N", "zeta_T"), at: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """ke_ratio over two parameters, as a matrix.

    Parameters
    ----------
    df, over, at
        As of `plane`, as is the choice of rows.

    Returns
    -------
    pandas.DataFrame
        ke_ratio, a column per value of `over[0]`, a row per value of `over[1]`, ascending; nan where there is no
        finished row.

    Raises
    ------
    InputError
        As `plane`.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> matrix = analysis.map_over(df, ("N", "zeta_T"), {"M_over_M0": 2, "V_over_V0": 1})
    >>> matrix.shape == (df["zeta_T"].nunique(), df["N"].nunique())
    True
    """
    return matrix(plane(df, over, at), over, KE.ratio)


def plane(
    df: pd.DataFrame, over: Sequence[str] = ("N", "zeta_T"), at: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """The finished rows of one plane of the grid, one per cell (the paper's figures 4 and 5).

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load` or of kernel.ke_ratios.
    over : two names
        Of N, zeta_T, M_over_M0, V_over_V0, and numbers of the model that are columns of `df`, as "spring.c2".
    at : mapping, optional
        Fixes the others at values of the table, to 1e-9 relative. One that is not in it must have a single value among
        the rows.

    Returns
    -------
    pandas.DataFrame
        The parameters, ke_ratio, `error` (estimated, relative), `chaotic` and, where `df` has them, `checked`,
        spread_low and spread_high; sorted by `over`; the index is that of `df` (the task). Where a cell was computed
        more than once, the row with the smallest error stands for it, of equals the first task.

    Raises
    ------
    InputError
        For unknown names, a value that the table does not have (the message lists what there is), a parameter left
        open, missing or unusable columns, and no finished row.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> cells = analysis.plane(df, ("M_over_M0", "V_over_V0"), {"N": 5, "zeta_T": 1e-2})
    >>> len(cells) == df["M_over_M0"].nunique() * df["V_over_V0"].nunique()
    True
    """
    return plane_of(KE, df, over, at)


def plane_of(of: Quantity, df: pd.DataFrame, over: Sequence[str], at: Mapping[str, float] | None) -> pd.DataFrame:
    """As `plane`, with the ratio and the error of any quantity."""
    known = inputs(df)
    columns = [*known, of.ratio, of.error, "chaotic"]
    _check_types(over, at)
    fixed = dict(at or {})
    _check_names(over, fixed, known)
    require(df, columns)
    done = finished(df)
    rows: pd.DataFrame = done[done[known].notna().all(axis=1)]
    if rows.empty:
        raise InputError("there is no finished row")
    rows = chosen(rows, fixed)
    _check_single(rows, df, [name for name in known if name not in over and name not in fixed])
    found = rows[with_optional(rows, columns, of)].sort_index(kind="stable")
    return found.sort_values([*over, of.error], kind="stable").drop_duplicates(list(over))


def matrix(cells: pd.DataFrame, over: Sequence[str], name: str) -> pd.DataFrame:
    """Column `name` of unique cells as a matrix: `over[0]` across, `over[1]` down, NaN where none."""
    # Not pivot_table, which averages and drops rows and columns that are NaN throughout.
    return cells.pivot(index=over[1], columns=over[0], values=name)  # noqa: PD010


def _check_types(over: object, at: object) -> None:
    problems = _not_names(over)
    if at is not None and not isinstance(at, Mapping):
        problems.append(f"at: must be a mapping of names to values, got {shown(at)}")
    elif wrong := [f"{name} = {shown(value)}" for name, value in (at or {}).items() if not _is_number(value)]:
        problems.append(f"at: must hold numbers, got {', '.join(wrong)}")
    if problems:
        raise InputError("; ".join(problems))


def _not_names(over: object) -> list[str]:
    """The problem, if what should name two parameters is no list of names."""
    if isinstance(over, str) or not isinstance(over, Sequence) or not all(isinstance(name, str) for name in over):
        return [f"over: must be two names of {', '.join(PARAMETERS)}, got {shown(over)}"]
    return []


def _is_number(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        float(value)
    except OverflowError:  # a whole number beyond all floats
        return False
    return True


def check_names(names: Sequence[str], known: Sequence[str] = PARAMETERS) -> None:
    """Raise InputError, naming each name that is none of the `known`."""
    if strange := [str(name) for name in names if name not in known]:
        hints = "".join(f"; {name}{hint}" for name in strange if (hint := did_you_mean(name, known)))
        raise InputError(f"unknown parameters {', '.join(strange)}; there are {', '.join(known)}{hints}")


def check_over(over: Sequence[str], known: Sequence[str] = PARAMETERS) -> None:
    """Raise InputError unless these are two different ones of the `known`."""
    if problems := _not_names(over):
        raise InputError(*problems)
    check_names(over, known)
    if len(over) != 2 or over[0] == over[1]:
        raise InputError(f"a picture is over two different parameters, not over {', '.join(over) or 'none'}")


def _check_names(over: Sequence[str], fixed: Mapping[str, float], known: Sequence[str]) -> None:
    check_names([*over, *fixed], known)
    check_over(over, known)
    both = [name for name in fixed if name in over]
    if both:
        raise InputError(f"{', '.join(both)} cannot be fixed: the map is over {', '.join(over)}")


def same(values: Any, value: float) -> Any:
    """Which of a table's `values` (one or many) are `value`, as typed from a printed list."""
    # Relative to the table's value: relative to an infinite `value` every one would match.
    return np.abs(values - value) <= RELATIVE_MATCH * np.abs(values)


def matching(rows: pd.DataFrame, name: str, value: float) -> "pd.Series[bool]":
    """Which rows have this value of a parameter; InputError, with the values nearest to it, where none has."""
    found: pd.Series[bool] = same(rows[name], value)
    if not found.any():
        raise InputError(missing(_values(rows, name), name, value, "finished row"))
    return found


def chosen(table: pd.DataFrame, at: Mapping[str, float]) -> pd.DataFrame:
    """The rows, finished or not, that have these values; InputError names all that no finished row has."""
    problems = list[str]()
    for name, value in at.items():
        try:
            matching(finished(table), name, value)
        except InputError as error:
            problems += error.problems
        else:
            table = table[same(table[name], value)]
    refuse_all(problems)
    return table


def missing(values: "np.ndarray[tuple[int], Any]", name: str, value: float, what: str) -> str:
    """What to say of a value that none of the `values` is."""
    near = np.sort(values[np.argsort(np.abs(values - value), kind="stable")[:_VALUES_LISTED]])
    return f"no {what} has {name} = {exactly(value)}; {_listing(near, len(values))}"


def _check_single(rows: pd.DataFrame, df: pd.DataFrame, names: Sequence[str]) -> None:
    values = {name: _values(rows, name) for name in names}
    several = {name: some for name, some in values.items() if len(some) > 1}
    if several:
        others = {name: df[name].nunique() - len(some) for name, some in several.items()}
        more = {name: f"; {count} more without a finished row" if count else "" for name, count in others.items()}
        listed = (
            f"{name} ({_listing(some[:_VALUES_LISTED], len(some))}{more[name]})" for name, some in several.items()
        )
        raise InputError(f"choose a value of {' and of '.join(listed)}, as in --at {next(iter(several))}=VALUE")


def _values(rows: pd.DataFrame, name: str) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    return np.unique(rows[name].to_numpy(dtype=np.float64))


def _listing(values: "np.ndarray[tuple[int], np.dtype[np.float64]]", total: int) -> str:
    shown = ", ".join(map(exactly, values))
    return f"there is {shown}" if len(values) == total else f"there are {total} values, such as {shown}"
