"""How well a ratio depends on one dimensionless number alone (figures 4d, 13, 14), and the lower edge of its cloud."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pandas.api.indexers import BaseIndexer

from analysis.checks import choice, require, require_one_chain
from analysis.front import Front, front
from analysis.quantity import KE, ratio
from analysis.table import flagged, left_out, reasons_text, unchecked_text, with_ratio
from kernel.notebook import ShownAsTable
from kernel.task import M0, V0
from sweep.errors import InputError
from sweep.schema import PARAMETERS

MIN_ROWS = 20  # of a collapse: fewer give no running median
WINDOW_SHARE = 0.05  # of all rows, in one window of the running median
WINDOW_ROWS = 8  # of a window at least; on a grid with so many rows per value each value is a window
NORMAL_SPREAD = 1.4826  # standard deviation over the median distance from the middle, of a normal distribution
ZERO_SHARE = 0.1  # of the smallest positive value: a zero counts as that, as it has no logarithm
SAME_DECIMALS = 9  # of a logarithm: equal products differ by rounding, some 1e-15, the values of an axis by far more
# A row pulls the median of its window towards itself, and is it once in n rows: of normal noise 1 - 1.25 / n of the
# spread is left, as half the gap between the middle rows goes. In 4e6 / n draws: 0.73 at n = 5, 0.86 at 9, 0.94 at 21.
OWN_PULL = 1.25
OWN_PULL_ROWS = 4  # from so many the formula holds: it gives 0.69 there, draws 0.72
NO_FRONT = "no falling lower edge"
_PI_ENDING = "($M$ over the chain's mass, $V$ over the speed of sound)."

Array = NDArray[np.float64]


class Number(NamedTuple):
    """A dimensionless number of an impact on a chain."""

    parts: tuple[str, ...]  # the parameters it is made of; a collapse must beat the best of these alone
    axis: str  # its formula, beside an axis
    meaning: str  # below a picture; empty where the formula says it all
    value: Callable[[pd.DataFrame], "pd.Series[float]"]  # of rows with the columns M and V that `meaning` defines


NUMBERS = {
    "Pi_IE": Number(
        ("M_over_M0", "V_over_V0"),
        r"$\Pi_\mathrm{IE} = M V^2$",
        rf"$\Pi_\mathrm{{IE}}$: energy of the impact over the chain's own {_PI_ENDING}",
        lambda df: df["M"] * df["V"] ** 2,
    ),
    "Pi_IV": Number(
        ("M_over_M0", "V_over_V0", "zeta_T"),
        r"$\Pi_\mathrm{IV} = M V / 2\zeta_T$",
        rf"$\Pi_\mathrm{{IV}}$: momentum of the impact over the viscous one {_PI_ENDING}",
        lambda df: df["M"] * df["V"] / (2 * df["zeta_T"]),
    ),
    "N_over_zeta_T": Number(("N", "zeta_T"), r"$N/\zeta_T$", "", lambda df: df["N"] / df["zeta_T"]),
}


@dataclass(frozen=True)
class Collapse(ShownAsTable):
    """How well a ratio collapses onto one number; made by `collapse`.

    Attributes
    ----------
    rows : pandas.DataFrame
        The rows used, with `against` as a column.
    against : str
        The number.
    scatter : float
        Of the ratio, in decades, about a running median in the logarithm of the number: 1.4826 times the median
        distance, the standard deviation of normal noise. Half of the rows lie further away than two thirds of it, and
        few that lie far away do not change it.
    alone : dict
        The same against each parameter that the number is made of.
    front : Front or None
        The lower edge of the cloud.
    left_out : dict
        How many rows, by reason; without an entry for chaos where no row was checked.
    unchecked : str
        How many of the rows used were not checked for chaos, in words; empty where all were.
    of : str
        The column of the ratio.
    """

    rows: pd.DataFrame
    against: str
    scatter: float
    alone: dict[str, float]
    front: Front | None
    left_out: dict[str, int]
    unchecked: str = ""
    of: str = KE.ratio

    def __str__(self) -> str:
        alone = ", ".join(f"{value:.3f} against {name}" for name, value in self.alone.items())
        line = f"scatter {self.scatter:.3f} decades of {self.of} against {self.against}, {alone}"
        return "; ".join(filter(None, (line, str(self.front or NO_FRONT), self.unchecked)))

    @property
    def before(self) -> float:
        """The smallest scatter that one parameter alone gives."""
        return min(self.alone.values())

    @property
    def reasons(self) -> str:
        """`left_out` in words."""
        return reasons_text(self.left_out)


def with_numbers(df: pd.DataFrame) -> pd.DataFrame:
    """The rows with Pi_IE = M V^2, Pi_IV = M V / (2 zeta_T) and N_over_zeta_T beside them; infinite without damping."""
    rows = df.assign(M=df["M_over_M0"] * M0, V=df["V_over_V0"] * V0)
    with np.errstate(divide="ignore"):
        return df.assign(**{name: number.value(rows) for name, number in NUMBERS.items()})


def collapse(df: pd.DataFrame, against: str = "Pi_IV", of: str = KE.ratio) -> Collapse:
    """Judge whether a ratio depends on one dimensionless number (the paper's figures 13 and 14).

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load` or of kernel.ke_ratios. Chaotic ones are left out, those that were not checked are not.
    against : str
        "Pi_IE" = M V^2, "Pi_IV" = M V / (2 zeta_T) or "N_over_zeta_T", with M and V themselves.
    of : str
        The ratio: "ke_ratio", or that of a quantity that the spec observes, as "wall_force_ratio".

    Returns
    -------
    Collapse
        Scatter in decades, before and after; `rows`, `front`, `left_out`.

    Raises
    ------
    InputError
        For an unknown number, what is no ratio, missing or unusable columns, and too few rows.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> found = analysis.collapse(df, "Pi_IE")
    >>> found.scatter < found.before    # Pi_IE collapses better than mass or speed alone
    True
    """
    choice("against", against, list(NUMBERS))
    column = ratio(of).ratio
    require(df, (*PARAMETERS, column, "chaotic"))
    require_one_chain(df)
    numbers = with_numbers(with_ratio(df, column))
    sharp = numbers[~flagged(numbers)]
    rows = sharp[np.isfinite(sharp[against])]
    reasons = left_out(df, column, above=0) | {"without damping": len(sharp) - len(rows)}
    if len(rows) < MIN_ROWS:
        raise InputError(f"a collapse needs at least {MIN_ROWS} rows, {len(rows)} are left ({reasons_text(reasons)})")
    y = np.log10(rows[column].to_numpy(float))
    alone = {name: scatter(np.log10(_positive(rows[name])), y) for name in NUMBERS[against].parts}
    x = np.log10(rows[against].to_numpy(float))
    return Collapse(rows, against, scatter(x, y), alone, front(x, y, column), reasons, unchecked_text(rows), column)


def _positive(values: "pd.Series[float]") -> Array:
    """A column for a logarithm: a zero becomes a tenth of the smallest positive value."""
    numbers = values.to_numpy(float)
    positive = numbers[numbers > 0]
    return np.maximum(numbers, ZERO_SHARE * positive.min() if len(positive) else 1.0)


def scatter(x: Array, y: Array) -> float:
    """Spread of y about its running median in x: the standard deviation of a normal distribution as wide."""
    x = np.round(x, SAME_DECIMALS)
    order = np.argsort(x, kind="stable")
    x, values = x[order], pd.Series(y[order])
    start, end = _windows(x)
    middle = values.rolling(_Bounds(start=start, end=end), min_periods=1).median()
    left = 1 - OWN_PULL / np.maximum(end - start, OWN_PULL_ROWS)
    return float(NORMAL_SPREAD * np.median(np.abs(values - middle) / left))


class _Bounds(BaseIndexer):
    """Windows from `start` to `end`, as pandas takes them."""

    start: NDArray[np.int64]
    end: NDArray[np.int64]

    def get_window_bounds(
        self, num_values: int = 0, min_periods: Any = None, center: Any = None, closed: Any = None, step: Any = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Those that it was made with; pandas wants its own arguments here."""
        return self.start, self.end


def _windows(x: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first row of every row's window and the one past the last; all rows of a value are in or out, by no order."""
    first, past = (np.searchsorted(x, x, side) for side in ("left", "right"))
    if len(np.unique(x)) * WINDOW_ROWS <= len(x):  # a grid: one median for each value
        return first, past
    half = max(WINDOW_ROWS, int(WINDOW_SHARE * len(x))) // 2
    low, high = np.maximum((first + past) // 2 - half, 0), np.minimum((first + past - 1) // 2 + half, len(x) - 1)
    return first[low], past[high]
