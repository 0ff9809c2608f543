"""What a task will cost, from its parameters: for the order of the work, the plan and the ETA."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel import rk45
from kernel.ke import COMPANION
from kernel.method import Integrator
from kernel.model import T_END_OVER_N, make_chain

# Fit to 3519 random runs over the paper's domain at rtol 1e-4 .. 1e-8: single tasks scatter by a factor of 1.5
# about it, a whole sweep is predicted much better. Force evaluations of both chains per unit time.
SMOOTH = 15.0
OF_RTOL, OF_V, OF_M, OF_N, OF_ZETA = -0.178, 0.136, 0.314, -0.135, -0.189
# Stiff damping: 6 evaluations per step, steps of 3.31 / (8 zeta), two chains, a tenth of the steps rejected.
STIFF = 1.1 * 2 * 6 * 8 / 3.31
OVERHEAD_SITES = 160  # an evaluation of N sites costs as much as N + 160 sites' arithmetic


def predict_work(columns: Mapping[str, NDArray[Any]], integrator: Integrator, certify: bool) -> NDArray[np.float64]:
    """Predicted work of each task, in site evaluations (see `seconds_per_work`)."""
    N = columns["N"].astype(np.float64)
    zeta = N * columns["zeta_T"]
    tolerance = integrator.rtol**OF_RTOL * (1.0 + COMPANION**OF_RTOL * certify)
    impact = columns["V_over_V0"] ** OF_V * columns["M_over_M0"] ** OF_M
    smooth = SMOOTH * tolerance * impact * N**OF_N * (0.01 + zeta) ** OF_ZETA
    evaluations = T_END_OVER_N * N * (smooth + STIFF * zeta * (1.0 + certify))
    return np.asarray(evaluations * (N + OVERHEAD_SITES))


def seconds_per_work() -> float:
    """Measured now, on this core: seconds for one unit of predicted work (compiles the kernel if need be)."""
    chain = make_chain(100, 4e-4, 1.0, bistable=True)
    best = np.inf
    for _ in range(4):  # the first one may compile
        start = time.perf_counter()
        run = rk45.integrate(chain, 0.26, 1e-6, 1e-9, 10**9, T_END_OVER_N * chain.N)
        best = min(best, (time.perf_counter() - start) / (run.evaluations * (chain.N + OVERHEAD_SITES)))
    return best
