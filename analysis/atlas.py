"""The stability atlas: which scheme `auto` takes where, with which step, and where the chaos is."""

import itertools
from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.errors import InputError
from kernel.ke import results_of
from kernel.method import choose
from kernel.model import M0, T_END_OVER_N, V0, chain_of
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import SWITCH, explicit_rule, implicit_rule, shock_stiffness
from kernel.status import DONE
from sweep.schema import PARAMETERS

TARGET = 1e-3  # of ke_ratio
SIDE_MAX = 200  # values per axis
OVER = (("N", "zeta_T"), ("M_over_M0", "V_over_V0"))
# The paper's domain (figures 4 and 5), and the values at which the other two parameters stand.
DOMAIN = {"N": (5, 500), "zeta_T": (1e-5, 1.0), "M_over_M0": (0.1, 10.0), "V_over_V0": (0.1, 10.0)}
AT = {"N": 100.0, "zeta_T": 4e-5, "M_over_M0": 2.0, "V_over_V0": 2.0}


def atlas(side: int) -> pd.DataFrame:
    """Both planes, one row per task; `plane` is 0 over N and zeta_T, 1 over M and V.

    Columns beside the parameters and those of the kernel: `step`, the mean step of the bistable chain, and
    `step_explicit`, the longest that the explicit scheme may take behind the front, in cell transit times.
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
    steps = np.array([_steps(int(N), zeta_T, M, V, integrator.accuracy) for N, zeta_T, M, V in tasks.tolist()])
    return pd.DataFrame(
        {"plane": number, "N": tasks[:, 0].astype(int)}
        | {name: columns[name] for name in PARAMETERS[1:]}
        | {"method": [_method(zeta) for zeta in (columns["N"] * columns["zeta_T"]).tolist()]}
        | {"step": steps[:, 0], "step_explicit": steps[:, 1]}
        | {name: results[name] for name in ("ke_ratio", "error", "chaotic", "evaluations")}
        | {"status": results["status"].astype(str)}
    )


def _axis(name: str, side: int) -> NDArray[np.float64]:
    values = np.geomspace(*DOMAIN[name], side)
    return np.unique(values.round()) if name == "N" else values


def _method(zeta: float) -> str:
    """Of the bistable chain, as kernel.splitting chooses."""
    return "explicit" if zeta < SWITCH else "implicit"


def _steps(N: int, zeta_T: float, M_over_M0: float, V_over_V0: float, accuracy: float) -> tuple[float, float]:
    """Mean step of the run (nan if it blew up), longest explicit step; without the contact's substeps.

    The kernel's results count all steps of all runs together, so the run is made again by itself.
    """
    M, V = M_over_M0 * M0, V_over_V0 * V0
    chain, budget = chain_of(N, zeta_T, M, True), choose().max_steps
    rule = explicit_rule(chain.zeta, accuracy)
    if _method(chain.zeta) == "explicit":
        run = run_explicit(chain, V, rule, budget, False)
    else:
        run = run_implicit(chain, V, implicit_rule(chain, V, accuracy), budget)
    bound = min(0.5 * rule.theta / np.sqrt(shock_stiffness(chain, V)), rule.h_max)
    return T_END_OVER_N * N / run.steps if run.status == DONE else float("nan"), float(bound)


def headlines(cells: pd.DataFrame) -> list[str]:
    """Per plane: how many cells each scheme has, the range of its steps, the share of chaos."""
    lines = []
    for number, over in enumerate(OVER):
        plane = cells[cells["plane"] == number]
        for method, some in plane.groupby("method"):
            step, chaotic = some["step"], int(some["chaotic"].sum())
            lines.append(
                f"{' and '.join(over)}: {method} in {len(some)} of {len(plane)} cells, mean step {step.min():.2g} to "
                f"{step.max():.2g} cell transit times; {chaotic} chaotic ({chaotic / len(some):.0%})"
            )
    return lines
