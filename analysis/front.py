"""The lower edge of a cloud of a ratio against a dimensionless number (figures 4d, 14)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.quantity import KE

BINS = 24  # of log x
ROWS_PER_BIN = 8  # a bin that holds fewer does not count: chance decides where its lowest row is
EDGE_QUANTILE = 0.01  # of the rows of a bin; the edge passes through it
FALL_START = -0.05  # decades of the ratio: above it the bistable chain is as good as the linear one, and nothing falls
FALL_END = 0.1  # decades above the lowest, where the fall has ended
MIN_BINS = 3  # of a fit: two points have no scatter
INTERVAL_BINS = 5  # of an interval: all slopes between four points lie on one side by chance in 1 of 12 clouds

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Front:
    """ratio = A x^s from x = `start` to `end`, near the lowest.

    `low` and `high` hold the exponent s with 95 %, were the edge a power law; both are nan where too few bins count.
    `of` is the column of the ratio.
    """

    A: float
    s: float
    low: float
    high: float
    start: float
    end: float
    of: str = KE.ratio

    def __str__(self) -> str:
        known = f" ({self.low:.3f} to {self.high:.3f})" if np.isfinite(self.low) else ""
        span = f"from x = {self.start:.3g} to {self.end:.3g}"
        return f"lower edge {self.of} = {self.A:.3g} x^{self.s:.3f}{known} {span}"


def front(x: Array, y: Array, of: str = KE.ratio) -> Front | None:
    """Where the lowest ratio falls as x grows, as a power law by Theil and Sen; None where it does not surely fall.

    `x`, `y`: logarithms (base 10). What lies beyond the lowest bin rises, and is not fitted, however high it rises.
    """
    middle, lowest = _edge(x, y)
    if len(lowest) < MIN_BINS:
        return None
    deepest = int(np.argmin(lowest))
    last = int(np.flatnonzero(lowest <= lowest[deepest] + FALL_END)[0])
    flat = np.flatnonzero(lowest[:last] > FALL_START)
    branch = slice(flat[-1] if len(flat) else 0, last + 1)
    if len(lowest[branch]) < MIN_BINS:
        return None
    from scipy.stats import theilslopes  # takes half a second to load, for which other commands need not wait

    # Joint: the line halves the edge's points. Medians of x and y apart would put it beside a curved edge.
    slope, level, low, high = theilslopes(lowest[branch], middle[branch], method="joint")
    low, high = (low, high) if len(lowest[branch]) >= INTERVAL_BINS else (np.nan, np.nan)
    if slope >= 0 or low <= 0 <= high:
        return None
    start, end = 10.0 ** middle[branch][[0, -1]]
    return Front(float(10.0**level), float(slope), float(low), float(high), float(start), float(end), of)


def _edge(x: Array, y: Array) -> tuple[Array, Array]:
    """The median x and the lowest y of every bin that holds enough rows."""
    from scipy.stats import binned_statistic

    full = binned_statistic(x, x, "count", BINS).statistic >= ROWS_PER_BIN
    middle = binned_statistic(x, x, "median", BINS).statistic
    lowest = binned_statistic(x, y, lambda rows: np.quantile(rows, EDGE_QUANTILE), BINS).statistic
    return middle[full], lowest[full]
