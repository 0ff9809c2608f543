"""N_transition on a grid, as the paper has it: where ke_ratio against N falls most steeply."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.figures.recipe import pick

HIGH, LOW = 1.0, 0.7  # a transition goes from above HIGH to below LOW times it


@dataclass(frozen=True)
class PowerLaw:
    """N = A zeta_T^-b through the transitions of one impact; `spread` is b's standard error."""

    A: float
    b: float
    spread: float


def transitions(df: pd.DataFrame, M_over_M0: float, V_over_V0: float) -> pd.DataFrame:
    """One row per zeta_T that has a transition: zeta_T, N, and the neighbours on the grid between which it lies."""
    rows = pick(df, M_over_M0=M_over_M0, V_over_V0=V_over_V0)
    found = []
    for zeta_T, line in rows[rows["zeta_T"] > 0].groupby("zeta_T"):
        line = line.sort_values("N")
        N, ratio = line["N"].to_numpy(float), line["ke_ratio"].to_numpy(float)
        if len(N) > 1 and ratio[0] > HIGH and ratio[-1] < LOW * HIGH:
            k = int(np.argmin(np.diff(np.log(ratio)) / np.diff(np.log(N))))
            found.append({"zeta_T": float(str(zeta_T)), "N": np.sqrt(N[k] * N[k + 1]), "from": N[k], "to": N[k + 1]})
    return pd.DataFrame(found, columns=["zeta_T", "N", "from", "to"])


def power_law(found: pd.DataFrame) -> PowerLaw | None:
    """The least-squares line in logarithms; None through fewer than four transitions."""
    if len(found) < 4:
        return None
    (slope, level), covariance = np.polyfit(np.log(found["zeta_T"]), np.log(found["N"]), 1, cov=True)
    return PowerLaw(float(np.exp(level)), float(-slope), float(np.sqrt(covariance[0, 0])))
