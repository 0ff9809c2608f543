"""Does one number predict another over many laws? A stated rule, with every law left out in turn."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import spearmanr

from analysis.outlook.draws import CONFIDENCE, ENDS, draws_of
from analysis.outlook.laws import LAW

MIN_LAWS = 6  # a curve of three numbers, and as many laws that it does not pass through by itself
DEGREE = 2  # of the curve, in the logarithm of the candidate
PREDICTS, HELPS = 0.75, 0.4  # of the variance over laws that is explained where each law is left out in turn
DRAWS = 500
SAME, ROUNDED = 1e-9, 9  # of a number, and in digits of a logarithm: what laws differ by less is rounding, and no law's
RULE = (
    f"a curve of degree {DEGREE} in the logarithm of the number is fitted to all laws but one, and tells that one; the "
    f"number predicts what explains at least {PREDICTS:.0%} of the variance so, and helps from {HELPS:.0%} on; "
    f"intervals: {CONFIDENCE:.0%}, from {DRAWS} draws of the laws"
)
Array = NDArray[np.float64]


def judged(rows: pd.DataFrame, of: str, candidates: Mapping[str, str]) -> pd.DataFrame:
    """One row per candidate, best first: rank correlation with its interval, share `explained`, `off`, `verdict`.

    `rows` has a row per law, or several (one per impact), which are left out together. `off` is how far the left-out
    ones are off, at the median, in the unit of `of`. No row where fewer than MIN_LAWS have both numbers, or the
    candidate has too few values for a curve.
    """
    found = [_judged(rows, of, *one) for one in candidates.items() if one[0] in rows]
    columns = ["name", "words", "laws", "rank", "rank_low", "rank_high", "explained", "low", "high", "off", "verdict"]
    table = pd.DataFrame([row for row in found if row], columns=columns)
    return table.sort_values("explained", ascending=False, kind="stable", ignore_index=True)


def _judged(rows: pd.DataFrame, of: str, name: str, words: str) -> dict[str, object] | None:
    known = rows[np.isfinite(rows[of]) & np.isfinite(rows[name]) & (rows[name] > 0)]
    laws = known.groupby(LAW).ngroup().to_numpy()
    x, y = np.log(known[name].to_numpy(float)), known[of].to_numpy(float)
    fewer = len(np.unique(x.round(ROUNDED))) < DEGREE + 2  # values than a curve has numbers, with one law left out
    if len(np.unique(laws)) < MIN_LAWS or fewer or np.ptp(y) <= SAME * np.abs(y).max():
        return None
    missed, mean = left_out(x, y, laws, DEGREE), left_out(x, y, laws, 0)
    ranks, shares = _drawn(x, y, missed, mean, laws)
    share = _share(missed, mean)
    return {
        **{"name": name, "words": words, "laws": len(np.unique(laws))},
        **{"rank": float(spearmanr(x, y)[0]), "rank_low": ranks[0], "rank_high": ranks[1]},
        **{"explained": share, "low": shares[0], "high": shares[1], "off": float(np.median(np.abs(missed)))},
        "verdict": "predicts" if share >= PREDICTS else "helps" if share >= HELPS else "does not",
    }


def left_out(x: Array, y: Array, laws: NDArray[np.intp], degree: int) -> Array:
    """What a curve through the other laws misses y by, for every row."""
    missed = np.empty(len(y))
    for law in np.unique(laws):
        own = laws == law
        middle, width = x[~own].mean(), max(x[~own].std(), SAME)
        curve = np.polyfit((x[~own] - middle) / width, y[~own], degree)
        missed[own] = y[own] - np.polyval(curve, (x[own] - middle) / width)
    return missed


def _share(missed: Array, mean: Array) -> float:
    return float(1 - np.sum(missed**2) / np.sum(mean**2))


def _drawn(x: Array, y: Array, missed: Array, mean: Array, laws: NDArray[np.intp]) -> tuple[list[float], list[float]]:
    """Intervals of the rank correlation and of the share, over draws of whole laws."""
    places = [np.flatnonzero(laws == law) for law in np.unique(laws)]
    ranks, shares = [], []
    for some in map(np.concatenate, draws_of(places, DRAWS)):
        if np.ptp(x[some]) > 0 and np.ptp(y[some]) > 0:
            ranks.append(spearmanr(x[some], y[some])[0])
            shares.append(_share(missed[some], mean[some]))
    return [*map(float, np.quantile(ranks, ENDS))], [*map(float, np.quantile(shares, ENDS))]
