"""Finding 1: lower finite viscosity performs better once the chain is fine enough."""

from typing import Any

import pandas as pd

from analysis.paper.findings.finding import Finding, Numbers, damped, ordered, usable, waiting_lines
from analysis.paper.numbers import COARSE_N, FINE_N, HIGH_DAMPING, MIN_POINTS, ORDERED_SHARE
from analysis.table import IMPACT

CLAIM = "lower finite viscosity performs better once N is fine enough"
DAMPING_SPAN = 10  # the dampings to compare must reach over at least this factor
RULE = (
    f"at the impact with the lowest ke_ratio of the largest N, and 0 < zeta_T <= {HIGH_DAMPING:g}: that ke_ratio "
    f"is below 1, and from its zeta_T upwards, at {MIN_POINTS} or more zeta_T over a factor of {DAMPING_SPAN} or more, "
    f"at least {ORDERED_SHARE:.0%} of all pairs have the lower ke_ratio at the lower zeta_T; at the smallest N at most "
    "half of them have"
)


def lower_viscosity(df: pd.DataFrame) -> Finding:
    """Whether the lower of two finite dampings has the lower ke_ratio in the finest chain, but not in the coarsest.

    The abstract: it "can" perform better, "to nearly 10^3x" (the best impact of figure 8), "but only when sufficiently
    fine discretization has been reached". So the impact with the lowest ke_ratio decides; how many others show the
    same is among the numbers. Only dampings up to HIGH_DAMPING count, where the paper sees a threshold in N. The frame
    must reach over a factor FINE_N / COARSE_N in N and DAMPING_SPAN in zeta_T. InputError as in `usable`.
    """
    rows, counts = usable(df)
    if lacks := waiting_lines(df, HIGH_DAMPING):
        return Finding(1, CLAIM, None, counts, lacks)
    compared = pd.DataFrame(
        [one for _, impact in damped(rows, HIGH_DAMPING).groupby(IMPACT) if (one := _compared(impact))]
    )
    if compared.empty:
        low = f"at least {MIN_POINTS} zeta_T up to {HIGH_DAMPING:g}, over a factor of {DAMPING_SPAN}"
        return Finding(
            1, CLAIM, None, counts, f"needs {low}, in two chains a factor of {FINE_N // COARSE_N} apart in N"
        )
    finest = compared[compared["N"] == compared["N"].max()]
    best = finest.loc[finest["ke_ratio"].idxmin()]
    numbers: Numbers = {
        "best impact": f"({best['M_over_M0']:.4g}, {best['V_over_V0']:.4g})",
        "N": int(best["N"]),
        "zeta_T": float(best["zeta_T"]),
        "ke_ratio": float(best["ke_ratio"]),
        "ke_ratio at the highest zeta_T": float(best["highest"]),
        "pairs in order": float(best["fine"]),
        f"in order at N = {best['N_coarse']}": float(best["coarse"]),
        "impacts that show it": f"{compared['shows'].sum()} of {len(compared)}",
    }
    return Finding(1, CLAIM, bool(best["shows"]), numbers | counts, RULE)


def _compared(impact: pd.DataFrame) -> dict[str, Any] | None:
    """The finest chain of one impact beside its coarsest; None where they do not reach far enough."""
    chains = [chain for _, chain in impact.sort_values("zeta_T").groupby("N") if _spans(chain)]
    if not chains or chains[-1]["N"].iloc[0] < FINE_N / COARSE_N * chains[0]["N"].iloc[0]:
        return None
    coarse, fine = chains[0], chains[-1]
    best = fine.iloc[int(fine["ke_ratio"].argmin())]
    above, below = (chain[chain["zeta_T"] >= best["zeta_T"]] for chain in (fine, coarse))
    shows = best["ke_ratio"] < 1 and _spans(above) and _in_order(above) >= ORDERED_SHARE and _in_order(below) <= 1 / 2
    return {
        **{name: best[name] for name in (*IMPACT, "N", "zeta_T", "ke_ratio")},
        "highest": fine["ke_ratio"].iloc[-1],
        "fine": _in_order(above),
        "N_coarse": coarse["N"].iloc[0],
        "coarse": _in_order(below),
        "shows": bool(shows),
    }


def _spans(chain: pd.DataFrame) -> bool:
    zeta_T = chain["zeta_T"]
    return len(chain) >= MIN_POINTS and bool(zeta_T.iloc[-1] >= DAMPING_SPAN * zeta_T.iloc[0])


def _in_order(chain: pd.DataFrame) -> float:
    return ordered(chain["zeta_T"].to_numpy(float), chain["ke_ratio"].to_numpy(float)) if len(chain) > 1 else 0.0
