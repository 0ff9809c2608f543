"""Finding 5: past the threshold the bistable chain wins over a wide range of impacts."""

import pandas as pd

from analysis.paper.findings.finding import Finding, Numbers, damped, reaches, usable, waiting
from analysis.paper.numbers import COARSE_N, FINE_N, LOW_DAMPING, MAJORITY, MIN_POINTS
from analysis.table import IMPACT

CLAIM = "past the threshold, the bistable chain wins over a wide range of impacts"
IMPACT_SPAN = 10  # impacts must reach over at least this factor, in mass and in speed, to be a wide range
RULE = (
    f"at every {LOW_DAMPING[0]:g} <= zeta_T <= {LOW_DAMPING[1]:g}: ke_ratio is below 1 for at least {MAJORITY:.0%} of "
    f"the impacts at every N >= {FINE_N}, and for more of them than at any N <= {COARSE_N}"
)


def wide_range(df: pd.DataFrame) -> Finding:
    """Whether a chain of FINE_N or more wins most impacts, and more of them than one of COARSE_N or fewer.

    A chain wins an impact where its ke_ratio is below 1. Section 5 of the paper, on figure 13: at zeta_T = 4e-5 and
    4e-4 a chain of 200 is past its threshold, and "the capacity for poor performance is limited, even with changing
    impactor conditions", unlike without damping. The impacts should be spread evenly in log M_over_M0 and log
    V_over_V0. InputError as in `usable`.
    """
    rows, counts = usable(df)
    needed = damped(df, *reversed(LOW_DAMPING))
    if lacking := waiting(needed[(needed["N"] <= COARSE_N) | (needed["N"] >= FINE_N)], df):
        return Finding(5, CLAIM, None, counts, lacking)
    lacks = [f"impacts over a factor of {IMPACT_SPAN} in {name}" for name in IMPACT if not _wide(rows[name])]
    dampings = [one for _, one in damped(rows, *reversed(LOW_DAMPING)).groupby("zeta_T") if reaches(one)]
    if not dampings:
        lacks += [f"a zeta_T from {LOW_DAMPING[0]:g} to {LOW_DAMPING[1]:g} with N <= {COARSE_N} and N >= {FINE_N}"]
    if lacks:
        return Finding(5, CLAIM, None, counts, f"needs {', and '.join(lacks)}")
    won = pd.DataFrame([_won(one) for one in dampings])
    numbers: Numbers = {
        "zeta_T": len(won),
        "least share of impacts won, fine": float(won["fine"].min()),
        "at the same zeta_T, coarse": float(won["coarse"].iloc[int(won["fine"].argmin())]),
        "highest ke_ratio, fine": float(won["worst"].max()),
    }
    undamped = rows[(rows["zeta_T"] == 0) & (rows["N"] >= FINE_N)]
    if len(undamped):
        numbers["share won without damping, fine"] = float((undamped["ke_ratio"] < 1).mean())
    holds = bool(((won["fine"] >= MAJORITY) & (won["fine"] > won["coarse"])).all())
    return Finding(5, CLAIM, holds, numbers | counts, RULE)


def _won(one: pd.DataFrame) -> dict[str, float]:
    """Shares of the impacts won at one damping: the least of the fine chains, the most of the coarse ones."""
    won = (one["ke_ratio"] < 1).groupby(one["N"]).mean()
    worst = one.loc[one["N"] >= FINE_N, "ke_ratio"].max()
    return {"fine": won[won.index >= FINE_N].min(), "coarse": won[won.index <= COARSE_N].max(), "worst": worst}


def _wide(values: "pd.Series[float]") -> bool:
    return bool(values.nunique() >= MIN_POINTS and values.max() >= IMPACT_SPAN * values.min())
