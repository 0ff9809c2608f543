"""Question e: what disorder in masses and stiffnesses costs the best impact of figure 8."""

from typing import Any

import numpy as np
import pandas as pd

from analysis.checks import require
from analysis.outlook.draws import ENDS, draws_of, share_of
from analysis.quantity import KE
from analysis.table import finished, flagged
from sweep.errors import InputError
from sweep.schema import PARAMETERS

MASS_SPREAD, STIFFNESS_SPREAD = "mass.spread", "stiffness.spread"
KINDS = ("mass", "stiffness", "both")
SURVIVES = 2.0  # times the ratio of the uniform chain
DRAWS = 500
RULE = (
    "a loss is ke_ratio with disorder over that of the uniform chain under the same impact, each beside the linear "
    f"chain with its own disorder; the optimum survives where the median of the draws is below {SURVIVES:g}, with its "
    "whole interval (95 %, from draws of the draws), and does not where that interval lies above"
)
CELL = list(PARAMETERS)


def losses(df: pd.DataFrame) -> pd.DataFrame:
    """One row per draw: the inputs, `kind`, `spread`, `loss` of ke_ratio, `loss_ke` of the peak itself.

    `loss_ke` compares with the uniform chain alone, `loss_all` is the loss of chaotic ones too. Of the others chaotic
    draws, and those of a cell whose uniform chain is chaotic or missing, have none (nan).
    """
    require(df, [*CELL, MASS_SPREAD, STIFFNESS_SPREAD, KE.ratio, "ke_bistable", "chaotic"])
    done = finished(df)
    even = done[(done[MASS_SPREAD] == 0) & (done[STIFFNESS_SPREAD] == 0)].drop_duplicates(CELL).set_index(CELL)
    uniform = even[~flagged(even)]
    if uniform.empty:
        raise InputError("no uniform chain to compare with is finished and calm")
    rows = done[(done[MASS_SPREAD] > 0) | (done[STIFFNESS_SPREAD] > 0)]
    there = rows[CELL].join(uniform[[KE.ratio, "ke_bistable"]], on=CELL)
    kind = np.select([rows[STIFFNESS_SPREAD] == 0, rows[MASS_SPREAD] == 0], KINDS[:2], KINDS[2])
    loss = (rows[KE.ratio] / there[KE.ratio]).where(~flagged(rows))
    peak = (rows["ke_bistable"] / there["ke_bistable"]).where(~flagged(rows))
    every = rows[KE.ratio] / rows[CELL].join(even[KE.ratio], on=CELL)[KE.ratio]
    spread = np.maximum(rows[MASS_SPREAD], rows[STIFFNESS_SPREAD])
    return rows.assign(kind=kind, spread=spread, loss=loss, loss_ke=peak, loss_all=every, uniform=there[KE.ratio])


def survival(lost: pd.DataFrame, by: tuple[str, ...] = ()) -> pd.DataFrame:
    """One row per kind and spread (and the columns `by`): median loss with its interval, the worst, and the verdict."""
    keys = [*by, "kind", "spread"]
    groups = lost.groupby(keys, observed=True)
    return pd.DataFrame([dict(zip(keys, key, strict=True)) | _survival(group) for key, group in groups])


def _survival(group: pd.DataFrame) -> dict[str, Any]:
    loss = group["loss"].dropna().to_numpy(float)
    row: dict[str, Any] = {"draws": len(group), "calm": len(loss), "median_all": float(group["loss_all"].median())}
    if not len(loss):
        return row | dict.fromkeys(("median", "low", "high", "worst", "median_ke"), np.nan) | {"verdict": "cannot tell"}
    low, high = _interval(group)
    ok, ok_low, ok_high = share_of(int((loss < SURVIVES).sum()), len(loss))
    row |= {"median": float(np.median(loss)), "low": low, "high": high, "worst": float(loss.max())}
    row |= {"median_ke": float(group["loss_ke"].median()), "below": ok, "below_low": ok_low, "below_high": ok_high}
    verdict = "survives" if high < SURVIVES else "does not survive" if low > SURVIVES else "cannot tell"
    return row | {"verdict": verdict}


def _interval(group: pd.DataFrame) -> tuple[float, float]:
    """The interval of the median loss, by drawing the random chains with replacement.

    Where the group has several cells these are drawn too, as a few cells decide much of the median.
    """
    rng = np.random.default_rng(0)
    calm = group.dropna(subset=["loss"])
    cells = [np.log(one.to_numpy(float)) for _, one in calm.groupby(CELL)["loss"]]
    medians = []
    for some in draws_of(cells, DRAWS, rng):
        medians.append(np.median(np.concatenate([one[rng.integers(len(one), size=len(one))] for one in some])))
    low, high = np.exp(np.quantile(medians, ENDS))
    return float(low), float(high)
