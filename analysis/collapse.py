"""Does ke_ratio depend on one dimensionless number (figures 4d, 13, 14)? A number for how well, and the lower edge."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import choice, require
from analysis.front import Front, front
from analysis.quantity import KE
from analysis.table import TO_COME, finished, flagged, looked_for_chaos, unchecked_told
from kernel.model import M0, V0
from sweep.errors import InputError
from sweep.schema import PARAMETERS

# What each number is made of: the collapse must beat the best of these alone.
AGAINST = {
    "Pi_IE": ("M_over_M0", "V_over_V0"),
    "Pi_IV": ("M_over_M0", "V_over_V0", "zeta_T"),
    "N_over_zeta_T": ("N", "zeta_T"),
}
LEAST = 20  # rows
WINDOW = 0.05  # of the rows in one running median
IN_WINDOW = 8  # rows at least, and as many for every value of a grid

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Collapse:
    """How well ke_ratio collapses onto one number; made by `collapse`.

    Attributes
    ----------
    rows : pandas.DataFrame
        The rows used, with `against` as a column.
    against : str
        The number.
    scatter : float
        Of ke_ratio, in decades, about a running median in the logarithm of the number.
    alone : dict
        The same against each parameter that the number is made of.
    front : Front or None
        The lower edge of the cloud.
    left_out : dict
        How many rows, by reason; nothing of chaos where nobody looked.
    unchecked : str
        How many of the rows used were not checked for chaos, in words; empty where all were.
    """

    rows: pd.DataFrame
    against: str
    scatter: float
    alone: dict[str, float]
    front: Front | None
    left_out: dict[str, int]
    unchecked: str = ""

    @property
    def before(self) -> float:
        """The least scatter that one parameter alone gives."""
        return min(self.alone.values())

    @property
    def reasons(self) -> str:
        """`left_out` in words."""
        return reasons_told(self.left_out)


def reasons_told(left_out: Mapping[str, int]) -> str:
    """For example "2 failed, 10 chaotic"."""
    return ", ".join(f"{count} {why}" for why, count in left_out.items())


def with_numbers(df: pd.DataFrame) -> pd.DataFrame:
    """The rows with Pi_IE = M V^2, Pi_IV = M V / (2 zeta_T) and N_over_zeta_T beside them; infinite without damping."""
    M, V = df["M_over_M0"] * M0, df["V_over_V0"] * V0
    with np.errstate(divide="ignore"):
        return df.assign(Pi_IE=M * V**2, Pi_IV=M * V / (2 * df["zeta_T"]), N_over_zeta_T=df["N"] / df["zeta_T"])


def collapse(df: pd.DataFrame, against: str = "Pi_IV") -> Collapse:
    """Judge whether ke_ratio depends on one dimensionless number.

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load` or of kernel.ke_ratios. Chaotic ones are left out, those that were not checked are not.
    against : str
        "Pi_IE" = M V^2, "Pi_IV" = M V / (2 zeta_T) or "N_over_zeta_T", with M and V themselves.

    Returns
    -------
    Collapse
        Scatter in decades, before and after; `rows`, `front`, `left_out`.

    Raises
    ------
    InputError
        For an unknown number, missing or unusable columns, and too few rows.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> found = analysis.collapse(df, "Pi_IE")
    >>> found.scatter < found.before    # Pi_IE collapses better than mass or speed alone
    True
    """
    choice("against", against, list(AGAINST))
    require(df, (*PARAMETERS, KE.ratio, "chaotic"))
    done = finished(df)
    numbers = with_numbers(done[(done[KE.ratio] > 0) & np.isfinite(done[KE.ratio])])
    sharp = numbers[~flagged(numbers)]
    rows = sharp[np.isfinite(sharp[against])]
    status = df["status"].astype(str) if "status" in df else pd.Series(dtype=str)
    waiting = {label or "without status": int((status == label).sum()) for label in TO_COME}
    left_out = {
        **{label: count for label, count in waiting.items() if count},
        "failed": len(df) - len(numbers) - sum(waiting.values()),
        **({"chaotic": len(numbers) - len(sharp)} if looked_for_chaos(numbers) else {}),
        "without damping": len(sharp) - len(rows),
    }
    if numbers.empty:
        raise InputError(f"no finished row has a {KE.ratio}")
    if len(rows) < LEAST:
        raise InputError(f"a collapse needs at least {LEAST} rows, {len(rows)} are left ({reasons_told(left_out)})")
    y = np.log10(rows[KE.ratio].to_numpy(float))
    alone = {name: scatter(np.log10(_positive(rows[name])), y) for name in AGAINST[against]}
    x = np.log10(rows[against].to_numpy(float))
    return Collapse(rows, against, scatter(x, y), alone, front(x, y), left_out, unchecked_told(rows))


def _positive(values: "pd.Series[float]") -> Array:
    """For a logarithm: zero as the smallest value that the column has besides."""
    numbers = values.to_numpy(float)
    positive = numbers[numbers > 0]
    return np.maximum(numbers, 0.1 * positive.min() if len(positive) else 1.0)


def scatter(x: Array, y: Array) -> float:
    """Spread of y about its running median in x: 1.4826 times the median distance, a standard deviation's worth."""
    order = np.lexsort((y, x))
    x, values = x[order], pd.Series(y[order])
    if len(np.unique(x)) * IN_WINDOW <= len(x):  # a grid: one median for each value
        middle = values.groupby(x).transform("median")
    else:
        window = max(IN_WINDOW, int(WINDOW * len(x))) | 1
        middle = values.rolling(window, center=True, min_periods=1).median()
    return float(1.4826 * np.median(np.abs(values - middle)))


def told(found: Collapse) -> str:
    """Its numbers in one line."""
    alone = ", ".join(f"{value:.3f} against {name}" for name, value in found.alone.items())
    line = f"scatter {found.scatter:.3f} decades of {KE.ratio} against {found.against}, {alone}"
    unchecked = f"; {found.unchecked}" if found.unchecked else ""
    return f"{line}; {found.front or 'no falling lower edge'}{unchecked}"
