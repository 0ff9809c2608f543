"""Question a: b and the prefactor of N_transition ~ zeta_T^-b, for every law and impact of a table."""

from typing import Any

import numpy as np
import pandas as pd

from analysis.outlook.laws import LAW, SHAPE, family, scaled_pairs, with_numbers
from analysis.power_law import fitted, line_through
from analysis.table import IMPACT, finished, flagged
from analysis.transition import transition
from sweep.errors import InputError

# In the middle of those looked at, where the prefactor is told: far from it, the prefactor says what b says.
MIDDLE_ZETA_T = 4e-4
KNOWN = 0.15  # half the width of the interval of b: a wider one tells nothing of how b depends on the law
NUMBERS = ["b", "b_low", "b_high", "N_middle", "N_middle_low", "N_middle_high"]


def thresholds(df: pd.DataFrame) -> pd.DataFrame:
    """One row per law and impact: the law's numbers, `lines`, `transitions`, `why_not`, b and N_middle with intervals.

    `b` and its interval (95 %) are those of `analysis.power_law`; `N_middle` is the law's N_transition at zeta_T =
    MIDDLE_ZETA_T; both nan where fewer than four zeta_T have a transition.
    """
    rows = [row for law, chain in df.groupby(LAW) for row in _impacts(dict(zip(LAW, law, strict=True)), chain)]
    found = with_numbers(pd.DataFrame(rows))
    return found.assign(log_N_middle=np.log(found["N_middle"]), family=found[SHAPE].map(family))


def known(found: pd.DataFrame) -> pd.DataFrame:
    """Those whose b is known to KNOWN."""
    return found[found["b_high"] - found["b_low"] <= 2 * KNOWN]


def _impacts(law: dict[str, Any], chain: pd.DataFrame) -> list[dict[str, Any]]:
    try:
        found = transition(chain)
    except InputError as error:  # no line of N that tells anything
        return [law | dict(zip(IMPACT, key, strict=True)) | _nothing(str(error)) for key, _ in chain.groupby(IMPACT)]
    return [law | dict(zip(IMPACT, key, strict=True)) | _power_law(lines) for key, lines in found.groupby(IMPACT)]


def _power_law(lines: pd.DataFrame) -> dict[str, Any]:
    reasons = lines["why_not"][lines["why_not"] != ""]
    there = int((lines["why_not"] == "").sum())
    counts = {"lines": len(lines), "transitions": there, "rows": int(lines["rows"].sum())}
    counts |= {"chaotic": int(lines["chaotic"].sum())}
    why = "" if reasons.empty else str(reasons.value_counts().index[0])
    if (used := fitted(lines)) is None:
        return _nothing(why) | counts
    line = line_through(used, middle=MIDDLE_ZETA_T)
    level = np.exp(line.level + np.array([0, -1, 1]) * line.reach_of_level)
    told = [line.b, line.b - line.reach, line.b + line.reach, *map(float, level)]
    return counts | {"why_not": why} | dict(zip(NUMBERS, told, strict=True))


def _nothing(why: str) -> dict[str, Any]:
    return {"lines": 0, "transitions": 0, "rows": 0, "chaotic": 0, "why_not": why} | dict.fromkeys(NUMBERS, np.nan)


def alike(df: pd.DataFrame) -> pd.DataFrame:
    """The pairs of calm rows of one shape at one V c2, which should have the same ke_ratio."""
    calm = finished(df)
    calm = calm[~flagged(calm)]
    return scaled_pairs(calm, ["N", "zeta_T", "M_over_M0"], ["ke_ratio"])
