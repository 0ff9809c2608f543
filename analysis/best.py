"""Best of the best: which impact a chain protects from most (the paper's figure 8)."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import inputs, names, require, require_one_chain, truth
from analysis.plane import check_names, check_over
from analysis.quantity import KE, Quantity, quantity
from analysis.table import CELL, IMPACT, finished, flagged, once, with_optional
from sweep.errors import InputError
from sweep.schema import PARAMETERS

Over = Sequence[str]


def best(
    df: pd.DataFrame,
    *,
    chaotic_too: bool = False,
    over: Over = ("N", "zeta_T"),
    of: str = KE.ratio,
    among: Sequence[str] = (),
) -> pd.DataFrame:
    """For every (N, zeta_T) the row with the lowest ke_ratio over all impacts (the paper's figure 8).

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load` or of kernel.ke_ratios.
    chaotic_too : bool
        Let chaotic rows compete with the others, which is how the paper's own map was made. Else they compete only in
        cells that have no other row: a chaotic row's ke_ratio is sensitive to its inputs, and the lowest of many such
        numbers is low by luck. A row that was not checked competes as it is, since nothing is known against it.

    over : sequence of str
        The two parameters, or numbers of the model, whose combinations are the cells, in place of N and zeta_T.
    of : str
        The ratio that is to be low: "ke_ratio", or that of a quantity that the spec observes, as "wall_force_ratio".
    among : sequence of str
        Numbers of the model whose chains compete with each other, as those over which a search looked for the lowest.

    Returns
    -------
    pandas.DataFrame
        One row per cell, sorted by them: N, zeta_T, the ratio, the M_over_M0 and V_over_V0 that gave it (and what is
        `among`), its error (estimated, relative; `error` is that of ke_ratio), whether it is `chaotic` and, where `df`
        has them, `checked`, spread_low and spread_high, all dimensionless; the index is that of `df` (the task). A cell
        without a finished row is left out. Of equal rows the fewest cells win, then the least damping, the lightest
        impactor, the slowest, the lowest task.

    Raises
    ------
    InputError
        Where columns are missing or unusable, or no finished row has the ratio; where a number of the model varies
        that is neither in `over` nor `among`: the rows of several chains must not compete as one's.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> cells = analysis.best(df)
    >>> len(cells) == len(df.groupby(["N", "zeta_T"]))
    True
    """
    rows = competing(df, chaotic_too=chaotic_too, over=over, of=of, among=among)
    cell, what = list(over), quantity(of)
    least, own = rows.groupby(cell)[what.ratio].transform("min"), _columns(what)
    others = [name for name in dict.fromkeys((*cell, *among)) if name not in own]
    columns = with_optional(rows, [*others, *own], what)
    found: pd.DataFrame = _in_order(rows.loc[rows[what.ratio] == least, columns]).drop_duplicates(cell)
    return found.sort_values(cell, kind="stable")


def _columns(of: Quantity) -> list[str]:
    return [*CELL, of.ratio, *IMPACT, of.error, "chaotic"]


def lowest_row(rows: pd.DataFrame, *, chaotic_too: bool = False, of: Quantity = KE) -> pd.DataFrame:
    """The row (1,) with the lowest ratio; of equal rows the first by N, then by zeta_T, then as in `best`.

    A chaotic row is taken only where there is no other or `chaotic_too` lets it compete: it may be low by luck.
    """
    known = rows[rows[of.ratio].notna() & ~guessed(rows)]
    firm = known[~flagged(known)]
    some = known if chaotic_too or firm.empty else firm
    return _in_order(some[some[of.ratio] == some[of.ratio].min()]).iloc[:1]


def guessed(rows: pd.DataFrame) -> NDArray[np.bool_]:
    """Which rows (n,) hold a number that was interpolated (analysis.sought), and not computed."""
    return rows["inferred"].to_numpy(bool) if "inferred" in rows else np.zeros(len(rows), bool)


def guessed_below(rows: pd.DataFrame, top: pd.DataFrame, of: Quantity = KE) -> str:
    """In words: how many interpolated numbers are lower than the row (1,) `top`; empty where none is."""
    lower = rows.loc[guessed(rows), of.ratio].to_numpy(float)
    lower = lower[lower < float(top[of.ratio].iloc[0])]
    if not len(lower):
        return ""
    are = f"{len(lower)} inferred cell{'s are' if len(lower) > 1 else ' is'}"
    return f"{are} lower, down to {lower.min():.4g}"


def _in_order(rows: pd.DataFrame) -> pd.DataFrame:
    """Sorted by N and zeta_T, then from the lightest impactor, the slowest, the first task on."""
    return rows.sort_index(kind="stable").sort_values([*CELL, *IMPACT], kind="stable")


def competing(
    df: pd.DataFrame,
    *,
    chaotic_too: bool = False,
    over: Over = ("N", "zeta_T"),
    of: str = KE.ratio,
    among: Sequence[str] = (),
) -> pd.DataFrame:
    """The rows among which `best` chooses: finished, with a finite ratio, chaotic ones as its docstring says."""
    truth("chaotic_too", chaotic_too)
    what = quantity(of)
    require(df, _columns(what))
    check_over(over, inputs(df))
    names("among", among)
    check_names(among, inputs(df))
    require_one_chain(df, but=[*over, *among])
    done = finished(df)
    rows = once(done[np.isfinite(done[what.ratio]) & done[list(PARAMETERS)].notna().all(axis=1)], what.ratio)
    if rows.empty:
        raise InputError(f"no finished row has a {what.ratio}")
    chaotic = flagged(rows)
    if chaotic_too or not chaotic.any():
        return rows
    cells = rows[list(over)].assign(chaotic=chaotic).groupby(list(over))
    only_chaotic = cells["chaotic"].transform("all").to_numpy(bool)
    chosen: pd.DataFrame = rows[~chaotic | only_chaotic]
    return chosen
