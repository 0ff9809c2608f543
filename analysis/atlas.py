"""The stability atlas: the longest stable step of every method, the method that `auto` takes, and where chaos is."""

import itertools

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.paper.numbers import DOMAIN
from analysis.stability import METHODS, longest_steps
from analysis.table import flagged, unchecked_text
from kernel.ke import results_of
from kernel.method import METHOD_WORDS, choose, methods_of
from kernel.model import make_chain
from kernel.task import V0
from sweep.errors import InputError
from sweep.schema import PARAMETERS

TARGET = 1e-3  # of ke_ratio
SIDE_MAX = 200  # values per axis
OVER = (("N", "zeta_T"), ("M_over_M0", "V_over_V0"))
# The values at which the other two parameters stand.
AT = {"N": 100.0, "zeta_T": 4e-5, "M_over_M0": 2.0, "V_over_V0": 2.0}


def atlas(side: int) -> pd.DataFrame:
    """The cells of both planes with their results; `plane` is 0 over N and zeta_T, 1 over M and V.

    Columns beside the parameters and those of the kernel: `method` as `auto` has chosen it for the bistable chain, and
    `step_explicit`, `step_implicit`, `step_rk45`, the longest stable steps of the bistable chain (analysis.stability).
    """
    every = tasks(side)
    columns = {name: every[name].to_numpy(np.float64) for name in PARAMETERS}
    integrator = choose("auto", TARGET)
    results = results_of(columns, integrator, certify=True)
    # As chosen before the run: a refined task may end with another method.
    N, zeta_T = columns["N"].astype(np.int64), columns["zeta_T"]
    chosen = np.array(METHOD_WORDS)[methods_of(N, N * zeta_T, False, integrator)]
    steps = np.array(
        [
            longest_steps(make_chain(int(N), zeta_T, M, bistable=True), V * V0)
            for N, zeta_T, M, V in zip(*columns.values(), strict=True)
        ]
    )
    return every.assign(
        **{"method": chosen}
        | {f"step_{name}": step for name, step in zip(METHODS, steps.T, strict=True)}
        | {name: results[name] for name in ("ke_ratio", "error", "chaotic", "checked", "evaluations")}
        | {"status": results["status"].astype(str)}
    )


def tasks(side: int) -> pd.DataFrame:
    """The cells of both planes, `side` values per axis: `plane` and the parameters."""
    if not 2 <= side <= SIDE_MAX:
        raise InputError(f"--side must be from 2 to {SIDE_MAX}, got {side}")
    planes = []
    for number, over in enumerate(OVER):
        axes = [_axis(name, side) if name in over else np.array([AT[name]]) for name in PARAMETERS]
        plane = pd.DataFrame(list(itertools.product(*axes)), columns=list(PARAMETERS)).astype({"N": int})
        planes.append(plane.assign(plane=number)[["plane", *PARAMETERS]])
    return pd.concat(planes, ignore_index=True)


def _axis(name: str, side: int) -> NDArray[np.float64]:
    values = np.geomspace(*DOMAIN[name], side)
    return np.unique(values.round()) if name == "N" else values


def headlines(cells: pd.DataFrame) -> list[str]:
    """The lines to print: for each plane the share of chaos and the range of every method's longest step."""
    lines = []
    for number, over in enumerate(OVER):
        plane = cells[cells["plane"] == number]
        counts = filter(None, (f"{int(flagged(plane).sum())} of {len(plane)} cells chaotic", unchecked_text(plane)))
        lines.append(f"{' and '.join(over)}: {'; '.join(counts)}")
        for method in METHODS:
            step = plane[f"step_{method}"]
            short = int(step.isna().sum())
            lines.append(
                f"  {method:8} stable up to steps of {step.min():.2g} to {step.max():.2g} cell transit times"
                + (f", shorter in {short} cells" if short else "")
            )
    return lines
