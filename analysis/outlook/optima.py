"""Question b: how the lowest ke_ratio of all impacts falls with Pi_IV, for every law of a table."""

from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import spearmanr, theilslopes

from analysis.best import best
from analysis.collapse import with_numbers as with_impact_numbers
from analysis.outlook.draws import ENDS, draws_of
from analysis.outlook.laws import C2, LAW, SHAPE, family, with_numbers
from analysis.table import IMPACT, flagged
from sweep.errors import InputError

MIN_POINTS = 5  # of a fit by Theil and Sen that has an interval (analysis.front)
FALLEN = 0.9  # the lowest ke_ratio is below it where there is a fall to fit
DRAWS = 500
RULE = (
    "of every law and zeta_T the lowest ke_ratio over all chains and impacts that are not chaotic; the branch past the "
    "threshold begins at the zeta_T where this is lowest of all and goes up from there; ke_ratio = A (Pi_IV c2)^-s by "
    f"Theil and Sen through those of the branch below {FALLEN:g}, from {MIN_POINTS} on, with 95 % intervals"
)
NUMBERS = ["s", "s_low", "s_high", "at_middle", "at_middle_low", "at_middle_high"]


def optima(df: pd.DataFrame) -> pd.DataFrame:
    """One row per law and zeta_T: the lowest ke_ratio, its inputs, Pi_IV, `scaled` = Pi_IV c2, `branch`, `edge`.

    `branch` is True where a power law is fitted; `edge` where the impact is at the end of the table's range, so that a
    better one may lie beyond.
    """
    rows = []
    for _, chain in df.groupby(LAW):
        try:
            cells = best(chain[~flagged(chain)])  # of a cell of chaotic rows alone it would take one
        except InputError:  # no row of this law is finished and not chaotic
            continue
        lowest = cells.loc[cells.groupby("zeta_T")["ke_ratio"].idxmin()]
        rows.append(lowest.join(chain[LAW]))
    if not rows:
        raise InputError("no law of the table has a finished row that is not chaotic")
    found = with_impact_numbers(pd.concat(rows, ignore_index=True))
    ends = {name: (df[name].min(), df[name].max()) for name in IMPACT}
    edge = np.any([found[name].isin(ends[name]).to_numpy() for name in IMPACT], axis=0)
    start = found.loc[found.groupby(LAW)["ke_ratio"].idxmin()].set_index(LAW)["zeta_T"].rename("start")
    past = found["zeta_T"] >= found[LAW].join(start, on=LAW)["start"]
    return found.assign(scaled=found["Pi_IV"] * found[C2], edge=edge, branch=past & (found["ke_ratio"] < FALLEN))


def falls(found: pd.DataFrame) -> pd.DataFrame:
    """One row per law: s and `at_middle`, the ke_ratio at the `middle` of all Pi_IV c2, with intervals, and `rank`.

    `found` is what `optima` gives. `rank` is the rank correlation of ke_ratio and Pi_IV over the points of the law.
    """
    middle = float(np.exp(np.log(found.loc[found["branch"], "scaled"]).median())) if found["branch"].any() else np.nan
    rows = with_numbers(pd.DataFrame([_fall(law, points, middle) for law, points in found.groupby(LAW)]))
    return rows.assign(log_at_middle=np.log(rows["at_middle"]), family=rows[SHAPE].map(family))


def _fall(law: Any, points: pd.DataFrame, middle: float) -> dict[str, Any]:
    kept = points[points["branch"] & np.isfinite(points["scaled"])]
    row = {**dict(zip(LAW, law, strict=True)), "points": len(kept), "edge": int(kept["edge"].sum()), "middle": middle}
    row |= {"lowest": float(points["ke_ratio"].min()), "rank": np.nan} | dict.fromkeys(NUMBERS, np.nan)
    if len(kept) < MIN_POINTS:
        return row
    x, y = np.log(kept["scaled"].to_numpy(float) / middle), np.log(kept["ke_ratio"].to_numpy(float))
    slope, _, low, high = theilslopes(y, x)
    drawn = np.quantile(_levels(x, y), ENDS)
    level = np.median(y - slope * x)
    told = [-slope, -high, -low, *np.exp([level, *drawn])]
    return row | {"rank": float(spearmanr(x, y)[0])} | dict(zip(NUMBERS, map(float, told), strict=True))


def _levels(x: Any, y: Any) -> list[float]:
    """The level of the fit, over draws of the points."""
    levels = []
    for some in draws_of(range(len(x)), DRAWS):
        if np.ptp(x[some]) > 0:
            levels.append(float(np.median(y[some] - _slope(x[some], y[some]) * x[some])))
    return levels


def _slope(x: Any, y: Any) -> float:
    """By Theil and Sen; scipy's, which also gives an interval, warns where points are drawn twice."""
    first, second = np.triu_indices(len(x), 1)
    run = x[second] - x[first]
    return float(np.median((y[second] - y[first])[run != 0] / run[run != 0]))
