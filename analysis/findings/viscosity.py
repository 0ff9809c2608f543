"""Finding 1: lower finite viscosity performs better once the chain is fine enough."""

import pandas as pd

from analysis.findings.finding import (
    COARSE,
    FINE,
    HIGH_DAMPING,
    IMPACT,
    LEAST,
    ORDERED,
    Finding,
    Numbers,
    damped,
    ordered,
    usable,
)

CLAIM = "lower finite viscosity performs better once N is fine enough"
SPAN = 10  # the dampings to compare must reach over at least this factor
RULE = (
    f"at the impact with the lowest ke_ratio of the largest N, and 0 < zeta_T <= {HIGH_DAMPING:g}: that ke_ratio is below "
    f"1, and from its zeta_T upwards, over a factor of {SPAN} or more, at least {ORDERED:.0%} of all pairs have the "
    f"lower ke_ratio at the lower zeta_T; at the smallest N at most half of them have"
)


def lower_viscosity(df: pd.DataFrame) -> Finding:
    """Whether the lower of two finite dampings has the lower ke_ratio in the finest chain, but not in the coarsest.

    The abstract: it "can" perform better, "to nearly 10^3x" (the best impact of figure 8), "but only when sufficiently
    fine discretization has been reached"; so the best impact decides, and how many show it is among the numbers. Below
    HIGH_DAMPING only, where the paper sees a threshold in N. The frame must reach over a factor FINE / COARSE in N and
    SPAN in zeta_T. InputError as in `usable`.
    """
    rows, counts = usable(df)
    told = pd.DataFrame([one for _, impact in damped(rows, HIGH_DAMPING).groupby(IMPACT) if (one := _compared(impact))])
    if told.empty:
        low = f"at least {LEAST} zeta_T up to {HIGH_DAMPING:g}, over a factor of {SPAN}"
        return Finding(1, CLAIM, None, counts, f"needs {low}, in two chains a factor of {FINE // COARSE} apart in N")
    finest = told[told["N"] == told["N"].max()]
    best = finest.loc[finest["ke_ratio"].idxmin()]
    numbers: Numbers = {
        "best impact": f"({best['M_over_M0']:.4g}, {best['V_over_V0']:.4g})",
        "N": int(best["N"]),
        "zeta_T": float(best["zeta_T"]),
        "ke_ratio": float(best["ke_ratio"]),
        "ke_ratio at the highest zeta_T": float(best["highest"]),
        "pairs in order": float(best["fine"]),
        f"in order at N = {best['N_coarse']}": float(best["coarse"]),
        "impacts that show it": f"{told['shows'].sum()} of {len(told)}",
    }
    return Finding(1, CLAIM, bool(best["shows"]), numbers | counts, RULE)


def _compared(impact: pd.DataFrame) -> dict[str, float] | None:
    """The finest chain of one impact beside its coarsest; None where they do not reach far enough."""
    grid = impact.pivot_table("ke_ratio", "N", "zeta_T")
    grid = grid[[_spans(line) for _, line in grid.iterrows()]]
    if grid.empty or grid.index[-1] < FINE / COARSE * grid.index[0]:
        return None
    fine = grid.iloc[-1].dropna()
    best = fine.idxmin()
    above, below = fine[fine.index >= best], grid.iloc[0][grid.columns >= best].dropna()
    here, there = _in_order(above), _in_order(below)
    return {
        **impact[IMPACT].iloc[0].to_dict(),
        "N": grid.index[-1],
        "zeta_T": best,
        "ke_ratio": fine[best],
        "highest": fine.iloc[-1],
        "fine": here,
        "N_coarse": grid.index[0],
        "coarse": there,
        "shows": bool(fine[best] < 1 and _spans(above) and here >= ORDERED and there <= 1 / 2),
    }


def _spans(line: "pd.Series[float]") -> bool:
    there = line.dropna().index
    return len(there) >= LEAST and bool(there[-1] >= SPAN * there[0])


def _in_order(line: "pd.Series[float]") -> float:
    return ordered(line.index.to_numpy(float), line.to_numpy(float)) if len(line) > 1 else 0.0
