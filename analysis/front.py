"""The lower edge of a cloud of ke_ratio against a dimensionless number (figures 4d, 14)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import theilslopes

BINS = 24  # of log x
IN_BIN = 8  # rows, else a bin does not count
EDGE = 0.01  # the front passes through this quantile of each bin
FLAT = -0.05  # decades: above, the bistable chain is as good as the linear one, and there is no front yet
NEAR = 0.1  # decades of the lowest, where the fall has ended
LEAST = 3  # bins of a fit
SURE = 5  # bins from which on there is an interval: all slopes between four lie on one side by chance in 1 of 12 clouds

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Front:
    """ke_ratio = A x^s from x = `start` to `end`, near the lowest.

    s lies between `low` and `high` (95 %, were the edge a power law); both are nan where too few bins tell.
    """

    A: float
    s: float
    low: float
    high: float
    start: float
    end: float

    def __str__(self) -> str:
        known = f" ({self.low:.3f} to {self.high:.3f})" if np.isfinite(self.low) else ""
        span = f"from x = {self.start:.3g} to {self.end:.3g}"
        return f"lower edge ke_ratio = {self.A:.3g} x^{self.s:.3f}{known} {span}"


def front(x: Array, y: Array) -> Front | None:
    """The branch on which the lowest ke_ratio falls, as a power law by Theil and Sen; None where it does not fall.

    `x`, `y`: logarithms (base 10). Of the two branches that meet at the lowest it is the one that comes from higher.
    """
    middle, lowest = _edge(x, y)
    if len(lowest) < LEAST:
        return None
    deepest = int(np.argmin(lowest))
    if lowest[deepest:].max() > lowest[: deepest + 1].max():
        middle, lowest, deepest = middle[::-1], lowest[::-1], len(lowest) - 1 - deepest
    last = int(np.flatnonzero(lowest <= lowest[deepest] + NEAR)[0])
    flat = np.flatnonzero(lowest[:last] > FLAT)
    branch = slice(flat[-1] if len(flat) else 0, last + 1)
    if len(lowest[branch]) < LEAST:
        return None
    # Joint: the line halves the edge's points. Medians of x and y apart would put it beside a curved edge.
    slope, level, low, high = theilslopes(lowest[branch], middle[branch], method="joint")
    low, high = (low, high) if len(lowest[branch]) >= SURE else (np.nan, np.nan)
    start, end = 10.0 ** middle[branch][[0, -1]]
    return Front(float(10.0**level), float(slope), float(low), float(high), float(start), float(end))


def _edge(x: Array, y: Array) -> tuple[Array, Array]:
    """Median x and lowest y of every bin that holds enough rows."""
    width = np.ptp(x) / BINS if np.ptp(x) > 0 else 1.0
    place = np.minimum(((x - x.min()) / width).astype(int), BINS - 1)
    full = [place == k for k in range(BINS) if np.count_nonzero(place == k) >= IN_BIN]
    middle = np.array([np.median(x[there]) for there in full])
    return middle, np.array([np.quantile(y[there], EDGE) for there in full])
