"""N_transition: the N at which ke_ratio, or another ratio, against N falls, at one damping and impact (figure 6b)."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import require, require_one_chain
from analysis.quantity import KE, Quantity, ratio
from analysis.table import IMPACT, LineRows, calm_line, done_lines, flagged, no_number, with_ratio
from sweep.errors import InputError
from sweep.plan.fall import HIGH, LOW, fall, last_high

LINE = [*IMPACT, "zeta_T"]
FOUND = ("N_transition", "N_low", "N_high", "by_slope", "by_level")  # nan where there is no transition
MIN_POINTS = 3  # N of a line: with two there is one slope only
INTERVAL = 0.025, 0.975  # its ends, as shares of the draws: 95 % lie between
DRAWS = 200  # of every line within the stated errors of its values; 5 of them lie beyond either end of the interval

Array = NDArray[np.float64]
Interval = tuple[float, float]


def transition(df: pd.DataFrame, of: str = KE.ratio) -> pd.DataFrame:
    """Whether each line (M_over_M0, V_over_V0, zeta_T) has a transition in N, and where (the paper's figure 6b).

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load` or of kernel.ke_ratios. Chaotic ones are left out, those that were not checked are not; nor do
        rows count whose ratio is not above 0, as it has no logarithm.
    of : str
        The ratio: "ke_ratio", or that of a quantity that the spec observes, as "wall_force_ratio".

    Returns
    -------
    pandas.DataFrame
        One row per line. `N_transition` is by the steepest slope of log ke_ratio against log N within the last fall
        through 1, which a rise by a tenth or more begins or ends. It lies between `N_low` and `N_high`: the neighbours
        among the rows used, and wherever the values moved within their error put it (a row without one, or with an
        infinite one, is not moved). Where all rows are used these are neighbours on the grid; `skipped` counts the N of
        `df` between them that this line lacks: chaotic, failed, or not computed. `by_slope` and `by_level` are the
        other DEFINITIONS. `why_not` says why there is none (nan then, and 0 `skipped`). `rows` were used, of which
        `unchecked` were not checked for chaos; `chaotic` ones were left out, and `without` whose ratio is not above 0.
        `failed` ones had ended without a number: the ratio may fall there.

    Raises
    ------
    InputError
        For what is no ratio, missing or unusable columns; where nothing is finished, or no line has three different N.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> found = analysis.transition(df)
    >>> found["N_transition"].notna().equals(found["why_not"] == "")
    True
    """
    what = ratio(of)
    require(df, ["N", *LINE, what.ratio, what.error, "chaotic"])
    require_one_chain(df)
    rows = with_ratio(df, what.ratio)
    if rows.groupby(LINE)["N"].nunique().max() < MIN_POINTS:
        raise InputError(f"a transition in N needs at least {MIN_POINTS} different N at one impact and zeta_T")
    if flagged(rows).all():
        raise InputError(f"every finished row is chaotic: none tells where {what.ratio} falls")
    every = df["N"].dropna().unique()
    lines = done_lines(df, LINE)  # those without a ratio, too, to be told of
    return pd.DataFrame([_line(key, line, what, every) for key, line in lines])


def _line(key: dict[str, Any], line: LineRows, of: Quantity, every: Array) -> dict[str, Any]:
    sharp, counts = calm_line(line.done, "N", of.ratio, above=0)
    N, values = sharp["N"].to_numpy(float), sharp[of.ratio].to_numpy(float)
    why = no_number(line.done, counts, of.ratio, above=0) or why_not(N, values)
    row = key | counts | {"failed": len(line.failed), "skipped": 0, "why_not": why} | dict.fromkeys(FOUND, np.nan)
    if row["why_not"]:
        return row
    error = sharp[of.error].to_numpy(float, na_value=np.nan)
    low, high = _widened(N, values, np.where(np.isfinite(error), error, 0.0))
    middles = {one.column: float(np.sqrt(np.prod(one.place(N, values)))) for one in DEFINITIONS.values()}
    skipped = np.count_nonzero((low < every) & (every < high) & ~np.isin(every, N))
    return row | {"skipped": int(skipped), "N_low": low, "N_high": high} | middles


def why_not(N: Array, ratio: Array) -> str:
    """Why there is no transition; empty where the ratio falls from above HIGH to below LOW and stays there."""
    if len(N) < MIN_POINTS:
        return f"fewer than {MIN_POINTS} N"
    if not ratio[: len(N) - 1].max() > HIGH:
        return f"never above {HIGH:g}"
    if not ratio[-1] < LOW:
        return f"not below {LOW:g} at the largest N"
    return ""


def steepest_log(N: Array, ratio: Array) -> Interval:
    """The two neighbours between which the logarithm of the ratio falls most steeply against log N."""
    return _steepest_in_fall(N, ratio, np.diff(np.log(ratio)) / np.diff(np.log(N)))


def steepest(N: Array, ratio: Array) -> Interval:
    """The same without logarithms."""
    return _steepest_in_fall(N, ratio, np.diff(ratio) / np.diff(N))


def crossing(N: Array, ratio: Array) -> Interval:
    """The two neighbours between which the ratio falls below HIGH for the last time."""
    k = last_high(ratio.tolist()) or 0
    return float(N[k]), float(N[k + 1])


def _steepest_in_fall(N: Array, ratio: Array, slope: Array) -> Interval:
    """The steepest step of the last fall through HIGH."""
    values = ratio.tolist()
    steps = fall(values, last_high(values) or 0)
    k = steps.start + int(np.argmin(slope[steps.start : steps.stop]))
    return float(N[k]), float(N[k + 1])


class Definition(NamedTuple):
    """One way to define the transition."""

    words: str  # of ke_ratio
    column: str  # that holds its N in what `transition` gives
    place: Callable[[Array, Array], Interval]

    def told(self, of: Quantity) -> str:
        """Its words, of another ratio."""
        return self.words.replace(KE.ratio, of.ratio)


DEFINITIONS = {
    "log_slope": Definition("steepest slope of log ke_ratio against log N", "N_transition", steepest_log),
    "slope": Definition("steepest slope of ke_ratio against N", "by_slope", steepest),
    "level": Definition("last crossing of ke_ratio = 1", "by_level", crossing),
}


def _widened(N: Array, ratio: Array, error: Array) -> Interval:
    """The interval of the steepest fall in 95 of 100 draws of the values within their errors, and of the values alone.

    An error above 1 is drawn as 1: larger ones would put the fall anywhere.
    """
    rng, (low, high) = np.random.default_rng(0), steepest_log(N, ratio)
    if not error.any():
        return low, high
    factors = np.exp(np.minimum(error, 1.0) * rng.standard_normal((DRAWS, len(N))))
    drawn = np.array([steepest_log(N, ratio * factor) for factor in factors])
    return min(low, float(np.quantile(drawn[:, 0], INTERVAL[0]))), max(
        high, float(np.quantile(drawn[:, 1], INTERVAL[1]))
    )
