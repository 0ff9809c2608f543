"""Finding 3: the bistable chain can be worse than the linear one."""

import pandas as pd

from analysis.paper.findings.finding import Finding, Numbers, both, damped, none_counts, usable, waiting
from analysis.paper.numbers import COARSE_N, LOW_DAMPING, MAJORITY
from analysis.table import IMPACT

CLAIM = "worse than linear at low N and viscosity, or without viscosity"
SIGNIFICANT_LOSS = 1.1  # "significantly": by ten times the loosest error of 1e-2 that a map is computed to
RULE = (
    f"in both regimes, N <= {COARSE_N} with 0 < zeta_T <= {LOW_DAMPING[1]:g} and every N with zeta_T = 0, there is an "
    f"impact at which ke_ratio is above {SIGNIFICANT_LOSS:g} in at least {MAJORITY:.0%} of the rows"
)


def worse_than_linear(df: pd.DataFrame) -> Finding:
    """Whether there is an impact that the bistable chain passes on significantly more of, in each of two regimes.

    The paper says that it "can" be worse (abstract), and that this "is not universal for all impact conditions"
    (section 3, on figure 5), so one impact is enough; how many there are is among the numbers.
    InputError as in `usable`.
    """
    rows, counts = usable(df)
    if lacking := waiting(pd.concat([*_regimes(df)]), df):
        return Finding(3, CLAIM, None, counts, lacking)
    (coarse, coarse_numbers), (undamped, undamped_numbers) = map(_regime, _regimes(rows), ("coarse", "undamped"))
    holds = both(coarse, undamped)
    which = (f"N <= {COARSE_N} and 0 < zeta_T <= {LOW_DAMPING[1]:g}", "zeta_T = 0")
    regimes = zip((coarse, undamped), _regimes(df), which, strict=True)
    lacks = [none_counts(some, words) for held, some, words in regimes if held is None]
    why = "; ".join(lacks) if holds is None else RULE
    return Finding(3, CLAIM, holds, coarse_numbers | undamped_numbers | counts, why)


def _regimes(rows: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    low = damped(rows, LOW_DAMPING[1])
    return low[low["N"] <= COARSE_N], rows[rows["zeta_T"] == 0]


def _regime(rows: pd.DataFrame, name: str) -> tuple[bool | None, Numbers]:
    if rows.empty:
        return None, {}
    losing = (rows["ke_ratio"] > SIGNIFICANT_LOSS).groupby([rows[column] for column in IMPACT]).mean() >= MAJORITY
    worst = rows.iloc[int(rows["ke_ratio"].argmax())]
    numbers: Numbers = {
        f"impacts that lose, {name}": f"{losing.sum()} of {len(losing)}",
        f"highest ke_ratio, {name}": float(worst["ke_ratio"]),
        f"its N, {name}": int(worst["N"]),
    }
    return bool(losing.any()), numbers
