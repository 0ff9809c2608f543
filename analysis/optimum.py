"""The best of all impacts and chains, and how far the table pins it down (the paper's figure 8)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.best import Over, competing, lowest_row
from analysis.checks import inputs, model_axes
from analysis.notes import NO_AXES, NO_ERROR, count
from analysis.quantity import KE, Quantity, quantity
from analysis.table import UNASKED_LABEL, checked, flagged
from kernel.notebook import ShownAsTable
from sweep.schema import PARAMETERS

Interval = tuple[float, float]
NO_INTERVAL = (float("nan"), float("nan"))


@dataclass(frozen=True)
class Optimum(ShownAsTable):
    """The lowest ratio of a table, and where it is; made by `optimum`. Chaotic only where nothing else is known.

    Attributes
    ----------
    ratio : float
        The lowest; where `of` is "ke_ratio" it is `ke_ratio` too.
    low, high : float
        Between which it lies by its error, of a chaotic row by its spread; nan where neither is known.
    chaotic : bool or None
        Whether it is sensitive to its inputs; None where that was not checked.
    at : dict
        The value of each parameter, and of each number of the model that varies among the rows.
    between : dict
        For each of them the interval that the table leaves open. It holds all rows whose ratio may be as low within
        the errors, and half a step of the grid beyond (in the logarithm, unless one is below 0 or it begins at 0),
        whatever became of the rows there; nan without an error.
    rivals : int or None
        Other rows that may be as low; None without an error.
    of : str
        The column of the ratio.
    """

    ratio: float
    low: float
    high: float
    chaotic: bool | None
    at: dict[str, float]
    between: dict[str, Interval]
    rivals: int | None
    of: str = KE.ratio

    @property
    def ke_ratio(self) -> float:
        """The lowest; nan where it is another ratio's."""
        return self.ratio if self.of == KE.ratio else float("nan")

    def __str__(self) -> str:
        chaotic = {True: ", chaotic", False: "", None: ", not checked for chaos"}[self.chaotic]
        if self.rivals is None:
            places = [f"{name} = {value:.3g}" for name, value in self.at.items()]
            return f"{self.of} = {self.ratio:.4g} ({NO_ERROR}{chaotic}) at {', '.join(places)}"
        places = [
            f"{name} = {self.at[name]:.3g} ({low:.3g} to {high:.3g})" for name, (low, high) in self.between.items()
        ]
        rivals = f"; {count(self.rivals, 'other row')} may be as low" if self.rivals else ""
        interval = f"{self.low:.4g} to {self.high:.4g}{chaotic}"
        return f"{self.of} = {self.ratio:.4g} ({interval}) at {', '.join(places)}{rivals}"


def optimum(
    df: pd.DataFrame,
    *,
    chaotic_too: bool = False,
    over: Over = ("N", "zeta_T"),
    of: str = KE.ratio,
    among: Sequence[str] = (),
) -> Optimum:
    """The best of all impacts and chains, and how far the table pins it down.

    Parameters
    ----------
    df, chaotic_too, over, of, among
        As of `best`, as is the choice of rows; a row that competes because its cell has none but chaotic ones is not
        the optimum while there are others. Of an unfinished sweep, or a search of a grid, give all rows,
        `load(path, done_only=False)`: their values are the grid's, half a step of which the intervals reach beyond.
        Not of a search that refines an axis, for a level or a transition: nobody looked at most of its further values.

    Returns
    -------
    Optimum
        Prints as one line. Rows without an error count as rivals where their ratio itself is as low.

    Raises
    ------
    InputError
        As `best`.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> print(analysis.optimum(df))    # doctest: +ELLIPSIS
    ke_ratio = ... at N = ...
    """
    return optimum_on(NO_AXES, df, chaotic_too=chaotic_too, over=over, of=of, among=among)


def optimum_on(
    axes: Mapping[str, NDArray[np.float64]],
    df: pd.DataFrame,
    *,
    chaotic_too: bool,
    over: Over,
    of: str,
    among: Sequence[str],
) -> Optimum:
    """The optimum of a table that may lack rows of its grid, whose values are those of `axes`."""
    rows, what = competing(df, chaotic_too=chaotic_too, over=over, of=of, among=among), quantity(of)
    # Where the axes are known, a row that a search did not ask for is of a step of theirs, or of one nobody looked at.
    told = df[df["status"].astype(str) != UNASKED_LABEL] if axes and "status" in df else df
    grid = {name: np.union1d(told[name].dropna(), axes.get(name, [])) for name in inputs(df)}
    one = lowest_row(rows, chaotic_too=chaotic_too, of=what)
    row, (low,), (high,) = one.iloc[0], *_bounds(one, what)
    varied = [name for name in model_axes(df) if len(grid[name]) > 1]
    at = {name: float(row[name]) for name in (*PARAMETERS, *varied)}
    found = Optimum(
        ratio=float(row[what.ratio]),
        low=float(low),
        high=float(high),
        chaotic=_chaotic(one),
        at=at,
        between=dict.fromkeys(at, NO_INTERVAL),
        rivals=None,
        of=what.ratio,
    )
    if np.isnan(found.high):
        return found
    least = _bounds(rows, what)[0]
    rivals = rows[np.where(np.isnan(least), rows[what.ratio], least) <= found.high]
    between = {name: _between(grid[name], rivals[name]) for name in at}
    return replace(found, between=between, rivals=len(rivals) - 1)


def _chaotic(one: pd.DataFrame) -> bool | None:
    """Whether this row (1,) is chaotic; None where it was not checked."""
    return True if flagged(one)[0] else False if checked(one)[0] else None


def _bounds(rows: pd.DataFrame, of: Quantity) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The interval of every row's ratio, by its error or spread; nan where neither is known."""
    ratio, error = (rows[name].to_numpy(float, na_value=np.nan) for name in (of.ratio, of.error))
    error = np.where(np.isfinite(error), error, np.nan)  # an infinite one says as little as none
    reach = np.abs(ratio) * error
    low, high = np.where(ratio < 0, ratio - reach, np.maximum(ratio - reach, 0)), ratio + reach
    if not of.spread or not {*of.spread} <= {*rows}:
        return low, high
    spread = flagged(rows) & np.isfinite(rows["spread_low"].to_numpy(float))
    return np.where(spread, rows["spread_low"], low), np.where(spread, rows["spread_high"], high)


def _between(grid: NDArray[np.float64], values: "pd.Series[float]") -> Interval:
    first, last = np.searchsorted(grid, [values.min(), values.max()])
    below, above = grid[max(first - 1, 0)], grid[min(last + 1, len(grid) - 1)]
    return _halfway(grid, below, grid[first]), _halfway(grid, grid[last], above)


def _halfway(grid: NDArray[np.float64], low: float, high: float) -> float:
    return float((low + high) / 2 if grid[0] < 0 or low == 0 else np.sqrt(low * high))
