"""Finding 1: lower finite viscosity performs better once the chain is fine enough."""

import numpy as np
import pandas as pd

from analysis.findings.finding import COARSE, FINE, IMPACT, LEAST, ORDERED, Finding, Numbers, ordered, usable

CLAIM = "lower finite viscosity performs better once N is fine enough"
SPAN = 10  # the dampings to compare must reach over at least this factor
RULE = (
    f"with the best impact at each N and zeta_T: at the largest N the lowest ke_ratio is below 1, and from its zeta_T "
    f"upwards, over a factor of {SPAN} or more, at least {ORDERED:.0%} of all pairs have the lower ke_ratio at the "
    f"lower zeta_T; at the smallest N at most half of them have"
)


def lower_viscosity(df: pd.DataFrame) -> Finding:
    """Whether the lower of two dampings, neither zero, has the lower ke_ratio in the finest chain but not in the coarsest.

    Of several impacts the best at each (N, zeta_T) counts, for which the paper says the same (section 3, on figures 4
    and 8: "better KE ratio is associated with lower damping given that a threshold of sufficiently fine discretization
    is met"); how many impacts show it alone is among the numbers. The frame must reach over a factor FINE / COARSE in
    N and SPAN in zeta_T. InputError as in `usable`.
    """
    rows, counts = usable(df)
    told = _compared(rows)
    if told is None:
        why = f"needs {LEAST} finite zeta_T over a factor of {SPAN}, at N a factor of {FINE // COARSE} apart"
        return Finding(1, CLAIM, None, counts, why)
    alone = [one["shows"] for _, impact in rows.groupby(IMPACT) if (one := _compared(impact))]
    numbers = told | {"impacts that show it alone": f"{sum(map(bool, alone))} of {len(alone)}"} | counts
    return Finding(1, CLAIM, bool(numbers.pop("shows")), numbers, RULE)


def _compared(rows: pd.DataFrame) -> Numbers | None:
    """The finest chain beside the coarsest; None where the rows do not reach far enough."""
    grid = rows[rows["zeta_T"] > 0].pivot_table("ke_ratio", "N", "zeta_T", "min")
    grid = grid[[_reaches(line) for _, line in grid.iterrows()]]
    if grid.empty or grid.index[-1] < FINE / COARSE * grid.index[0]:
        return None
    fine, coarse = grid.iloc[-1].dropna(), grid.iloc[0]
    best = float(fine.idxmin())
    above, below = fine[fine.index >= best], coarse[coarse.index >= best].dropna()
    here, there = (ordered(one.index.to_numpy(), one.to_numpy()) if len(one) > 1 else 0.0 for one in (above, below))
    return {
        "shows": bool(_reaches(above) and fine.min() < 1 and here >= ORDERED and there <= 1 / 2),
        "largest N": int(grid.index[-1]),
        "best zeta_T there": best,
        "ke_ratio there": float(fine.min()),
        "ke_ratio at the highest zeta_T": float(fine.iloc[-1]),
        "pairs in order": here,
        "smallest N": int(grid.index[0]),
        "pairs in order at it": there,
    }


def _reaches(line: "pd.Series[float]") -> bool:
    there = line.dropna().index.to_numpy(dtype=np.float64)
    return len(there) >= LEAST and bool(there[-1] >= SPAN * there[0])
