"""The best of all impacts and chains, and how far the table pins it down (the paper's figure 8)."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.best import competing
from sweep.schema import PARAMETERS

Interval = tuple[float, float]


@dataclass(frozen=True)
class Optimum:
    """The lowest ke_ratio, between `low` and `high` by its error (of a chaotic row, its spread), and where it is.

    `at` holds each parameter's value and `between` what the table cannot tell it from: the values of all rows whose
    ke_ratio may be as low within the errors, half a step of the grid (in the logarithm) beyond them.
    """

    ke_ratio: float
    low: float
    high: float
    chaotic: bool
    at: dict[str, float]
    between: dict[str, Interval]
    rivals: int  # other rows that may be as low

    def __str__(self) -> str:
        places = [
            f"{name} = {self.at[name]:.3g} ({low:.3g} to {high:.3g})" for name, (low, high) in self.between.items()
        ]
        rivals = f"; {self.rivals} other rows may be as low" if self.rivals else ""
        return f"ke_ratio = {self.ke_ratio:.4g} ({self.low:.4g} to {self.high:.4g}) at {', '.join(places)}{rivals}"


def optimum(df: pd.DataFrame, *, chaotic_too: bool = False) -> Optimum:
    """Which rows compete, and the errors, as `best`."""
    rows = competing(df, chaotic_too=chaotic_too)
    low, high = _bounds(rows)
    top = int(np.argmin(rows["ke_ratio"].to_numpy()))
    rivals = rows[low <= high[top]]
    row = rows.iloc[top]
    between = {name: _between(rows[name], rivals[name]) for name in PARAMETERS}
    at = {name: float(row[name]) for name in PARAMETERS}
    ratio = float(row["ke_ratio"])
    return Optimum(ratio, float(low[top]), float(high[top]), bool(row["chaotic"]), at, between, len(rivals) - 1)


def _bounds(rows: pd.DataFrame) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Between which the ke_ratio of every row lies; a row without an error is taken at its word."""
    ratio, error = rows["ke_ratio"].to_numpy(float), np.nan_to_num(rows["error"].to_numpy(float), posinf=1.0)
    low, high = ratio * np.maximum(1 - error, 0), ratio * (1 + error)
    if "spread_low" not in rows:
        return low, high
    spread = rows["chaotic"].to_numpy() & np.isfinite(rows["spread_low"].to_numpy(float))
    return np.where(spread, rows["spread_low"], low), np.where(spread, rows["spread_high"], high)


def _between(all_values: "pd.Series[float]", values: "pd.Series[float]") -> Interval:
    grid = np.unique(all_values.to_numpy(float))
    first, last = np.searchsorted(grid, [values.min(), values.max()])
    below, above = grid[max(first - 1, 0)], grid[min(last + 1, len(grid) - 1)]
    return float(np.sqrt(below * grid[first])), float(np.sqrt(grid[last] * above))
