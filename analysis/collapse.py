"""Does ke_ratio depend on one dimensionless number (figures 4d, 13, 14)? A number for how well, and the lower front."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import theilslopes

from analysis.errors import InputError
from analysis.table import finished, require
from kernel.model import M0, V0
from sweep.schema import PARAMETERS

# What each number is made of: the collapse must beat the best of these alone.
AGAINST = {
    "Pi_IE": ("M_over_M0", "V_over_V0"),
    "Pi_IV": ("M_over_M0", "V_over_V0", "zeta_T"),
    "N_over_zeta_T": ("N", "zeta_T"),
}
LEAST = 20  # rows
WINDOW = 0.05  # of the rows in one running median
BINS, IN_BIN, FRONT = 20, 8, 0.05  # the front is this quantile of ke_ratio in each bin of log x

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Collapse:
    """`rows` with `against` as a column; scatters in decades of ke_ratio about a running median in log x."""

    rows: pd.DataFrame
    against: str
    scatter: float  # after: against `against`
    alone: dict[str, float]  # before: against each of what it is made of
    front: tuple[float, float] | None  # (A, s) of ke_ratio = A x^s through the front; None with too few rows
    slope: tuple[float, float]  # 95 % of s
    left_out: dict[str, int]  # rows by reason

    @property
    def before(self) -> float:
        """The least scatter that one parameter alone gives."""
        return min(self.alone.values())


def with_numbers(df: pd.DataFrame) -> pd.DataFrame:
    """The rows with Pi_IE = M V^2, Pi_IV = M V / (2 zeta_T) and N_over_zeta_T beside them; infinite without damping."""
    M, V = df["M_over_M0"] * M0, df["V_over_V0"] * V0
    with np.errstate(divide="ignore"):
        return df.assign(Pi_IE=M * V**2, Pi_IV=M * V / (2 * df["zeta_T"]), N_over_zeta_T=df["N"] / df["zeta_T"])


def collapse(df: pd.DataFrame, against: str = "Pi_IV") -> Collapse:
    """Judge one of AGAINST on a table's rows. InputError where columns are missing or too few rows are left."""
    if against not in AGAINST:
        raise InputError(f"against: must be one of {', '.join(AGAINST)}, got {against!r}")
    require(df, (*PARAMETERS, "ke_ratio", "chaotic"))
    done = finished(df)
    numbers = with_numbers(done[(done["ke_ratio"] > 0) & np.isfinite(done["ke_ratio"])])
    sharp = numbers[~numbers["chaotic"]]
    rows = sharp[np.isfinite(sharp[against])]
    left_out = {
        "failed": len(df) - len(numbers),
        "chaotic": len(numbers) - len(sharp),
        "without damping": len(sharp) - len(rows),
    }
    if len(rows) < LEAST:
        told = ", ".join(f"{count} {why}" for why, count in left_out.items())
        raise InputError(f"a collapse needs at least {LEAST} rows, {len(rows)} are left ({told})")
    y = np.log10(rows["ke_ratio"].to_numpy(float))
    alone = {name: scatter(np.log10(_positive(rows[name])), y) for name in AGAINST[against]}
    x = np.log10(rows[against].to_numpy(float))
    front, slope = _front(x, y)
    return Collapse(rows, against, scatter(x, y), alone, front, slope, left_out)


def _positive(values: "pd.Series[float]") -> Array:
    """For a logarithm: zero as the smallest value that the column has besides."""
    numbers = values.to_numpy(float)
    positive = numbers[numbers > 0]
    return np.maximum(numbers, 0.1 * positive.min() if len(positive) else 1.0)


def scatter(x: Array, y: Array) -> float:
    """Spread of y about its running median in x: 1.4826 times the median distance, a standard deviation's worth."""
    order = np.lexsort((y, x))
    x, values = x[order], pd.Series(y[order])
    if len(np.unique(x)) * IN_BIN <= len(x):  # a grid: one median for each value
        middle = values.groupby(x).transform("median")
    else:
        window = max(IN_BIN, int(WINDOW * len(x))) | 1
        middle = values.rolling(window, center=True, min_periods=1).median()
    return float(1.4826 * np.median(np.abs(values - middle)))


def _front(x: Array, y: Array) -> tuple[tuple[float, float] | None, tuple[float, float]]:
    """The line through the FRONT quantile of every bin that holds enough rows, by Theil and Sen."""
    nowhere = None, (np.nan, np.nan)
    if np.ptp(x) == 0:
        return nowhere
    place = np.minimum((BINS * (x - x.min()) / np.ptp(x)).astype(int), BINS - 1)
    full = [k for k in range(BINS) if np.count_nonzero(place == k) >= IN_BIN]
    if len(full) < 3:
        return nowhere
    middle = np.array([np.median(x[place == k]) for k in full])
    lowest = np.array([np.quantile(y[place == k], FRONT) for k in full])
    slope, level, low, high = theilslopes(lowest, middle)
    return (float(10.0**level), float(slope)), (float(low), float(high))


def told(found: Collapse) -> str:
    """Its numbers in one line."""
    alone = ", ".join(f"{value:.3f} against {name}" for name, value in found.alone.items())
    line = f"scatter {found.scatter:.3f} decades of ke_ratio against {found.against}, {alone}"
    return line if found.front is None else f"{line}; {front_told(found.front, found.slope)}"


def front_told(front: tuple[float, float], slope: tuple[float, float]) -> str:
    """The lower edge with the interval of its slope."""
    return f"front ke_ratio = {front[0]:.3g} x^{front[1]:.3f} ({slope[0]:.3f} to {slope[1]:.3f})"
