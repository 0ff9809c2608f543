"""SUNDIALS CVODE through scikit-sundae: BDF and Adams, banded Jacobian, force and crest detector compiled by numba.

Unknowns in the order u_0, v_0, u_1, v_1, ..: CVODE forms the banded Jacobian from six force evaluations. Its root
finder stops at every zero of the middle site's acceleration: the crests of its velocity, on CVODE's own polynomial.
"""

import math
from importlib.metadata import version
from importlib.util import find_spec

import numpy as np

from kernel.task import T_END_OVER_N

from .common import ATOL_OVER_RTOL, Missing, Solver, one_by_one, parameters
from .force import interleaved, middle_acceleration


def peak_speed(method, task, rtol, *, bistable):
    """max |v_mid| over continuous time; nan where the solver gives up."""
    from sksundae.cvode import CVODE

    p, t_end, mid = parameters(task, bistable=bistable), T_END_OVER_N * task.N, (task.N + 1) // 2
    y = np.zeros(2 * task.N + 2)
    y[1] = p[5]

    def crests(t, y, out):
        middle_acceleration(y, p, out)

    crests.terminal, crests.direction = [False], [0]
    run = CVODE(
        lambda t, y, dy: interleaved(y, p, dy),
        method=method,
        rtol=rtol,
        atol=ATOL_OVER_RTOL * rtol,
        linsolver="band",
        lband=3,
        uband=2,
        max_num_steps=10_000_000,
        eventsfn=crests,
        num_events=1,
    ).solve(np.array([0.0, 0.5 * t_end, t_end]), y)  # two outputs: with none in between it would keep every state
    if not run.success:
        return math.nan
    seen = [run.y[:, 2 * mid + 1], *([run.y_events[:, 2 * mid + 1]] if run.y_events is not None else [])]
    return float(np.max(np.abs(np.concatenate(seen))))


def ke_ratio(method, task, rtol):
    """ke_bistable / ke_linear of one task."""
    bistable, linear = (peak_speed(method, task, rtol, bistable=law) for law in (True, False))
    return (bistable / linear) ** 2


def solvers():
    """Both families over the tolerances that CVODE's manual recommends."""
    if find_spec("sksundae") is None:
        raise Missing("scikit-sundae is not installed")
    ladder = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
    return [
        Solver(
            f"CVODE {method}",
            ladder,
            one_by_one(lambda task, rtol, m=method: ke_ratio(m, task, rtol)),
            judged=3,
            budget=14.0,
        )
        for method in ("BDF", "Adams")
    ]


def versions():
    """What ran."""
    return f"scikit-sundae {version('scikit-sundae')}"
