"""Question c: the paper's findings by other figures of merit, and whom the ratio of kinetic energies misleads."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from analysis.outlook.draws import ENDS, draws_of, share_of
from analysis.paper.findings import findings
from analysis.paper.findings.finding import Finding, in_place_of_ke
from analysis.quantity import KE, ratio
from analysis.table import IMPACT, finished, flagged
from sweep.errors import InputError


@dataclass(frozen=True)
class Merit:
    """A figure of merit: a column of a ratio, below 1 where the chain is better than the linear one."""

    name: str
    words: str
    column: str
    more_is_better: bool = False


MERITS = (
    Merit("ke", "kinetic energy of the middle site", KE.ratio),
    Merit("wall_force", "largest push on the wall", "wall_force_ratio"),
    Merit("acceleration", "largest acceleration of the middle site", "acceleration_ratio"),
    Merit("impulse", "impulse that the wall takes", "impulse_ratio"),
    Merit("dissipated", "share that is dissipated, linear over bistable", "dissipated_ratio", more_is_better=True),
)
MISLED = 0.25  # of the impacts: the chain that the kinetic energy chooses is worse than the linear one
DRAWS = 300
RULE = (
    "for every impact the chain (N and zeta_T) with the lowest ratio of kinetic energies is chosen; this misleads "
    f"about a figure where at more than {MISLED:.0%} of the impacts, with the whole interval, the chosen chain is "
    "worse than the linear one by it; does not where the interval lies below; else nobody can tell from so many impacts"
)


def in_place(df: pd.DataFrame, merit: Merit) -> pd.DataFrame:
    """The rows with this figure in place of ke_ratio, as the rules of the findings read it."""
    return in_place_of_ke(df, ratio(merit.column), merit.more_is_better)


def held(df: pd.DataFrame) -> dict[str, list[Finding]]:
    """The findings 1, 2, 3 and 5 by every figure."""
    return {merit.name: [one.by(ratio(merit.column)) for one in findings(in_place(df, merit))] for merit in MERITS}


def misled(df: pd.DataFrame) -> pd.DataFrame:
    """One row per other figure: rank correlation with ke_ratio, and what becomes of the chains that ke_ratio chooses.

    `worse` of the `impacts`, a share with its interval (Wilson, 95 %), are worse than the linear chain there; `price`
    is the median over impacts of the figure there over the lowest that any chain has. Chaotic rows are left out.
    """
    return pd.DataFrame([_misled(df, merit) for merit in MERITS[1:]])


def pairs(df: pd.DataFrame, merit: Merit) -> pd.DataFrame:
    """The calm rows that have both ratios: ke_ratio and `figure`."""
    rows = df.assign(figure=in_place(df, merit)[KE.ratio])
    rows = finished(rows)
    kept: pd.DataFrame = rows[~flagged(rows) & (rows[KE.ratio] > 0) & np.isfinite(rows["figure"])]
    if kept.empty:
        raise InputError(f"no finished row that is not chaotic has both ke_ratio and {merit.column}")
    return kept


def chosen(rows: pd.DataFrame) -> pd.DataFrame:
    """Of what `pairs` gives, for every impact the row with the lowest ke_ratio, and the `least` figure of its rows."""
    lowest = rows.loc[rows.groupby(IMPACT)[KE.ratio].idxmin()]
    return lowest.join(rows.groupby(IMPACT)["figure"].min().rename("least"), on=IMPACT)


def _misled(df: pd.DataFrame, merit: Merit) -> dict[str, object]:
    rows = pairs(df, merit)
    won = chosen(rows)
    worse = int((won["figure"] > 1).sum())
    share, low, high = share_of(worse, len(won))
    rank = float(spearmanr(rows[KE.ratio], rows["figure"])[0])
    ends = _rank_interval(rows)
    numbers = {"rows": len(rows), "rank": rank, "rank_low": ends[0], "rank_high": ends[1], "impacts": len(won)}
    numbers |= {"worse": worse, "share": share, "low": low, "high": high}
    price = float((won["figure"] / won["least"]).median())
    return {"name": merit.name, "words": merit.words, **numbers, "price": price, "verdict": _verdict(low, high)}


def _verdict(low: float, high: float) -> str:
    return "misleads" if low > MISLED else "does not mislead" if high < MISLED else "cannot tell"


def _rank_interval(rows: pd.DataFrame) -> list[float]:
    """Of the rank correlation, over draws of whole impacts: the rows of one are no independent ones."""
    x, y = rows[KE.ratio].to_numpy(float), rows["figure"].to_numpy(float)
    places = list(rows.groupby(IMPACT).indices.values())
    found = []
    for some in map(np.concatenate, draws_of(places, DRAWS)):
        found.append(float(spearmanr(x[some], y[some])[0]))
    return [*map(float, np.nanquantile(found, ENDS))]
