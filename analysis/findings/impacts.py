"""Finding 5: past the threshold the bistable chain wins over a wide range of impacts."""

import pandas as pd

from analysis.findings.finding import COARSE, FINE, IMPACT, LOW_DAMPING, MOST, Finding, Numbers, low_damping, usable

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
    low = low_damping(rows, LOW_DAMPING[0])
    dampings = [one for _, one in low.groupby("zeta_T") if one["N"].min() <= COARSE and one["N"].max() >= FINE]
    if not dampings or not all(_wide(rows[name]) for name in IMPACT):
        needs = f"zeta_T from {LOW_DAMPING[0]:g} to {LOW_DAMPING[1]:g} at N <= {COARSE} and N >= {FINE}"
        return Finding(5, CLAIM, None, counts, f"needs impacts over a factor of {RANGE} in mass and speed, and {needs}")
    numbers: Numbers = {}
    verdicts = []
    for one in dampings:
        won = (one["ke_ratio"] < 1).groupby(one["N"]).mean()
        fine, coarse = float(won[won.index >= FINE].min()), float(won[won.index <= COARSE].max())
        at = f"zeta_T = {one['zeta_T'].iloc[0]:.3g}"
        numbers |= {f"won at {at}, fine": fine, f"won at {at}, coarse": coarse}
        worst = one.loc[one["N"] >= FINE, "ke_ratio"].max()
        numbers[f"highest ke_ratio at {at}, fine"] = float(worst)
        verdicts.append(fine >= MOST and fine > coarse)
    undamped = rows[(rows["zeta_T"] == 0) & (rows["N"] >= FINE)]
    if len(undamped):
        numbers["won without damping, fine"] = float((undamped["ke_ratio"] < 1).mean())
    return Finding(5, CLAIM, all(verdicts), numbers | counts, RULE)


def _wide(values: "pd.Series[float]") -> bool:
    return bool(values.nunique() > 2 and values.max() >= RANGE * values.min())
