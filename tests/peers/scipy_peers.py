"""scipy's RK45 (ode45's pair) and DOP853, with a force compiled by numba.

The solver classes are stepped by hand, as tuned code does: solve_ivp would keep every state. The dense output, which
for DOP853 costs three force evaluations, is built only for steps whose crest may exceed the best so far.
"""

import math

import numpy as np
import scipy.integrate

from kernel.task import T_END_OVER_N

from .common import ATOL_OVER_RTOL, Solver, one_by_one, parameters
from .force import blocked, crest


def peak_speed(method, task, rtol, *, bistable):
    """max |v_mid| over continuous time; nan where the solver gives up."""
    p, n, mid = parameters(task, bistable=bistable), task.N + 1, task.N + 1 + (task.N + 1) // 2
    g, y = np.empty(n), np.zeros(2 * n)
    y[n] = p[5]
    run = method(lambda t, y: blocked(y, p, g), 0.0, y, T_END_OVER_N * task.N, rtol=rtol, atol=ATOL_OVER_RTOL * rtol)
    best = v = a = 0.0
    while run.status == "running":
        run.step()
        v_next, a_next = float(run.y[mid]), float(run.f[mid])
        x = crest(v, a, v_next, a_next, run.step_size, best)
        if x > 0.0:
            best = max(best, abs(run.dense_output()(run.t_old + x * run.step_size)[mid]))
        best, v, a = max(best, abs(v_next)), v_next, a_next
    return best if run.status == "finished" else math.nan


def ke_ratio(method, task, rtol):
    """ke_bistable / ke_linear of one task."""
    bistable, linear = (peak_speed(method, task, rtol, bistable=law) for law in (True, False))
    return (bistable / linear) ** 2


def solvers():
    """RK45 for loose, DOP853 for tight tolerances; each over both."""
    ladder = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    methods = {"scipy RK45": scipy.integrate.RK45, "scipy DOP853": scipy.integrate.DOP853}
    return [
        Solver(name, ladder, one_by_one(lambda task, rtol, m=method: ke_ratio(m, task, rtol)), judged=3, budget=16.0)
        for name, method in methods.items()
    ]


def versions():
    """What ran."""
    return f"scipy {scipy.__version__}"
