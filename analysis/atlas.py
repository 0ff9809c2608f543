"""The stability atlas: how long a step of every method may be, which scheme `auto` takes where, where the chaos is."""

import itertools
from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.errors import InputError
from analysis.stability import METHODS, longest_steps
from analysis.table import flagged, unchecked_told
from kernel.ke import results_of
from kernel.method import METHOD_WORDS, choose, methods_of
from kernel.model import V0, make_chain
from sweep.schema import PARAMETERS

TARGET = 1e-3  # of ke_ratio
SIDE_MAX = 200  # values per axis
OVER = (("N", "zeta_T"), ("M_over_M0", "V_over_V0"))
# The paper's domain (figures 4 and 5), and the values at which the other two parameters stand.
DOMAIN = {"N": (5, 500), "zeta_T": (1e-5, 1.0), "M_over_M0": (0.1, 10.0), "V_over_V0": (0.1, 10.0)}
AT = {"N": 100.0, "zeta_T": 4e-5, "M_over_M0": 2.0, "V_over_V0": 2.0}


def atlas(side: int) -> pd.DataFrame:
    """Both planes, one row per task; `plane` is 0 over N and zeta_T, 1 over M and V.

    Columns beside the parameters and those of the kernel: `method` as `auto` has chosen it for the bistable chain, and
    `step_explicit`, `step_implicit`, `step_rk45`, the longest stable steps of the bistable chain (analysis.stability).
    """
    if not 2 <= side <= SIDE_MAX:
        raise InputError(f"--side must be from 2 to {SIDE_MAX}, got {side}")
    return pd.concat([_plane(number, over, side) for number, over in enumerate(OVER)], ignore_index=True)


def _plane(number: int, over: Sequence[str], side: int) -> pd.DataFrame:
    axes = [_axis(name, side) if name in over else np.array([AT[name]]) for name in PARAMETERS]
    tasks = np.array(list(itertools.product(*axes)))
    columns = dict(zip(PARAMETERS, tasks.T, strict=True))
    integrator = choose("auto", TARGET)
    results = results_of(columns, integrator, certify=True)
    # As chosen before the run: a refined task may end with another method.
    N, zeta_T = columns["N"].astype(np.int64), np.ascontiguousarray(columns["zeta_T"])
    chosen = np.array(METHOD_WORDS)[methods_of(N, zeta_T, True, integrator)]
    steps = np.array(
        [longest_steps(make_chain(int(N), zeta_T, M, bistable=True), V * V0) for N, zeta_T, M, V in tasks.tolist()]
    )
    return pd.DataFrame(
        {"plane": number, "N": tasks[:, 0].astype(int)}
        | {name: columns[name] for name in PARAMETERS[1:]}
        | {"method": chosen}
        | {f"step_{name}": step for name, step in zip(METHODS, steps.T, strict=True)}
        | {name: results[name] for name in ("ke_ratio", "error", "chaotic", "checked", "evaluations")}
        | {"status": results["status"].astype(str)}
    )


def _axis(name: str, side: int) -> NDArray[np.float64]:
    values = np.geomspace(*DOMAIN[name], side)
    return np.unique(values.round()) if name == "N" else values


def headlines(cells: pd.DataFrame) -> list[str]:
    """Per plane: the share of chaos, and the range of every method's longest stable step."""
    lines = []
    for number, over in enumerate(OVER):
        plane = cells[cells["plane"] == number]
        told = filter(None, (f"{int(flagged(plane).sum())} of {len(plane)} cells chaotic", unchecked_told(plane)))
        lines.append(f"{' and '.join(over)}: {'; '.join(told)}")
        for method in METHODS:
            step = plane[f"step_{method}"]
            short = int(step.isna().sum())
            lines.append(
                f"  {method:8} stable up to steps of {step.min():.2g} to {step.max():.2g} cell transit times"
                + (f", shorter in {short} cells" if short else "")
            )
    return lines
