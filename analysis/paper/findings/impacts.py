"""Finding 5: past the threshold the bistable chain wins over a wide range of impacts."""

import pandas as pd

from analysis.paper.findings.finding import (
    COARSE,
    FINE,
    IMPACT,
    LEAST,
    LOW_DAMPING,
    MOST,
    Finding,
    Numbers,
    damped,
    reaches,
    usable,
)

CLAIM = "past the threshold, the bistable chain wins over a wide range of impacts"
RANGE = 10  # impacts must reach over at least this factor, in mass and in speed, to be a wide range
RULE = (
    f"at every {LOW_DAMPING[0]:g} <= zeta_T <= {LOW_DAMPING[1]:g}: ke_ratio is below 1 for at least {MOST:.0%} of the "
    f"impacts at every N >= {FINE}, and for more of them than at any N <= {COARSE}"
)


def wide_range(df: pd.DataFrame) -> Finding:
    """Whether most impacts are won at N of FINE or more, and more of them than at N of COARSE or less.

    Section 5, on figure 13: at zeta_T = 4e-5 and 4e-4 the chain of 200 is past its threshold, and "the capacity for
    poor performance is limited, even with changing impactor conditions", unlike without damping. The impacts should be
    spread evenly in log M_over_M0 and log V_over_V0. InputError as in `usable`.
    """
    rows, counts = usable(df)
    lacks = [f"impacts over a factor of {RANGE} in {name}" for name in IMPACT if not _wide(rows[name])]
    dampings = [one for _, one in damped(rows, *reversed(LOW_DAMPING)).groupby("zeta_T") if reaches(one)]
    if not dampings:
        lacks += [f"a zeta_T from {LOW_DAMPING[0]:g} to {LOW_DAMPING[1]:g} with N <= {COARSE} and N >= {FINE}"]
    if lacks:
        return Finding(5, CLAIM, None, counts, f"needs {', and '.join(lacks)}")
    told = pd.DataFrame([_won(one) for one in dampings])
    numbers: Numbers = {
        "zeta_T": len(told),
        "least share of impacts won, fine": float(told["fine"].min()),
        "at the same zeta_T, coarse": float(told["coarse"].iloc[int(told["fine"].argmin())]),
        "highest ke_ratio, fine": float(told["worst"].max()),
    }
    undamped = rows[(rows["zeta_T"] == 0) & (rows["N"] >= FINE)]
    if len(undamped):
        numbers["share won without damping, fine"] = float((undamped["ke_ratio"] < 1).mean())
    holds = bool(((told["fine"] >= MOST) & (told["fine"] > told["coarse"])).all())
    return Finding(5, CLAIM, holds, numbers | counts, RULE)


def _won(one: pd.DataFrame) -> dict[str, float]:
    """Shares of the impacts won at one damping: the least of the fine chains, the most of the coarse ones."""
    won = (one["ke_ratio"] < 1).groupby(one["N"]).mean()
    worst = one.loc[one["N"] >= FINE, "ke_ratio"].max()
    return {"fine": won[won.index >= FINE].min(), "coarse": won[won.index <= COARSE].max(), "worst": worst}


def _wide(values: "pd.Series[float]") -> bool:
    return bool(values.nunique() >= LEAST and values.max() >= RANGE * values.min())
