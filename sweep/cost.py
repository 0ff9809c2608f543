"""What a task will cost, from its parameters: for the order of the work, the plan and the ETA."""

import time
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.certify import looser
from kernel.ke import PARAMETERS, results_of
from kernel.method import AUTO, Integrator, choose
from kernel.splitting.rules import SWITCH


class Law(NamedTuple):
    """Seconds of both chains = c a^p V^q M^r (0.01 + zeta)^s N (N + sites) + start + stiff N zeta (N + sites).

    a: the splitting's accuracy, or rk45's rtol.
    """

    c: float
    a: float
    V: float
    M: float
    damping: float
    sites: float  # a pass over N sites costs as much as N + this many sites' arithmetic
    start: float
    stiff: float = 0.0


# Fit to 2849 random runs (N 3..700, zeta_T 0..2, M/M0 and V/V0 0.05..20) in one sitting on one core: single tasks
# scatter by a factor of 1.5 about it, the sum of many is within 5 %. `seconds_per_work` compares this machine.
EXPLICIT = Law(1.60e-9, -0.379, 0.148, 0.323, 0.137, 211, 49e-6)
IMPLICIT = Law(1.65e-10, -0.484, 0.145, 0.208, -0.185, 807, 148e-6)
RK45 = Law(9.24e-9, -0.165, 0.137, 0.268, -0.118, 188, 8e-6, 1.52e-8)


def predict_work(columns: Mapping[str, NDArray[Any]], integrator: Integrator, certify: bool) -> NDArray[np.float64]:
    """Predicted work of each task: seconds on the machine of the fit."""
    work = _work(columns, integrator)
    return work + _work(columns, looser(integrator)) if certify else work


def _work(columns: Mapping[str, NDArray[Any]], integrator: Integrator) -> NDArray[np.float64]:
    if integrator.kind != AUTO:
        return _by_law(columns, RK45, integrator.rtol)
    explicit = columns["N"] * columns["zeta_T"] < SWITCH
    laws = (_by_law(columns, law, integrator.accuracy) for law in (EXPLICIT, IMPLICIT))
    return np.where(explicit, *laws)


def _by_law(columns: Mapping[str, NDArray[Any]], law: Law, a: float) -> NDArray[np.float64]:
    N, zeta_T, M, V = (np.asarray(columns[name], np.float64) for name in PARAMETERS)
    zeta, size = N * zeta_T, N * (N + law.sites)
    smooth = law.c * a**law.a * V**law.V * M**law.M * (0.01 + zeta) ** law.damping
    return np.asarray((smooth + law.stiff * zeta) * size + law.start)


def seconds_per_work() -> float:
    """Measured now, on this core: seconds for one unit of predicted work (compiles the kernel if need be)."""
    N, zeta_T = np.array([20, 50, 100, 150] * 3), np.repeat([1e-4, 1e-3, 3e-2], 4)
    columns = {"N": N, "zeta_T": zeta_T, "M_over_M0": np.ones(12), "V_over_V0": np.ones(12)}
    integrator, best = choose(), np.inf
    for _ in range(4):  # the first one may compile
        start = time.perf_counter()
        results_of(columns, integrator, certify=True)
        best = min(best, time.perf_counter() - start)
    return float(best / predict_work(columns, integrator, certify=True).sum())
