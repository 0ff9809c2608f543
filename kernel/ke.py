"""ke_ratio of many tasks or of one: both chains, their peaks, an error estimate.

A task is computed by itself: its bits depend neither on its neighbours in the batch nor on who computes it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.method import MAX_STEPS, Integrator, choose
from kernel.model import M0, V0, Array
from kernel.peaks import METHOD_WORDS, Peak, peak_of
from kernel.status import BAD_INPUT, DONE, NOT_FINITE, WORDS
from kernel.task import Task, broken_rule

PARAMETERS = ("N", "zeta_T", "M_over_M0", "V_over_V0")

# One row per task. Not done: every number that is not known is nan.
RESULT = np.dtype(
    [
        ("ke_ratio", "f8"),  # ke_bistable / ke_linear; below 1 the bistable chain protects better
        ("ke_bistable", "f8"),  # peak kinetic energy of the middle site over the initial total energy TE
        ("ke_linear", "f8"),  # the same of the comparative linear chain
        ("t_peak_bistable", "f8"),  # when, over N
        ("t_peak_linear", "f8"),
        ("error", "f8"),  # estimated relative error of ke_ratio; nan where not asked for
        ("chaotic", "?"),  # the number is not determined by the inputs (False where error is not asked for)
        ("method", "S16"),  # the integrator of the bistable chain
        ("steps", "i8"),  # accepted steps of all integrations
        ("evaluations", "i8"),  # force evaluations of the chain, of all integrations
        ("site_evaluations", "i8"),  # the same, counting only the sites that the wave had reached
        ("status", "S16"),  # "done", or why not (kernel.status.SENTENCES)
    ]
)
# What the compiled loop writes: the numbers of RESULT, with codes for status and method.
NUMBERS = ("ke_ratio", "ke_bistable", "ke_linear", "t_peak_bistable", "t_peak_linear", "error", "steps", "evaluations")
COLUMNS = (*NUMBERS, "site_evaluations", "status", "method")
RATIO, BISTABLE, LINEAR, T_BISTABLE, T_LINEAR, ERROR, STEPS, EVALUATIONS, SITES, STATUS, METHOD = range(len(COLUMNS))


@dataclass(frozen=True)
class KeRatio:
    """What one task gives; the fields are those of RESULT."""

    ke_ratio: float
    ke_bistable: float
    ke_linear: float
    t_peak_bistable: float
    t_peak_linear: float
    error: float
    chaotic: bool
    method: str
    steps: int
    evaluations: int
    site_evaluations: int
    status: str


def ke_ratio(
    N: int,
    zeta_T: float,
    M_over_M0: float,
    V_over_V0: float,
    accuracy: float = 1e-3,
    method: str = "auto",
    rtol: float | None = None,
    atol: float | None = None,
    *,
    certify: bool = True,
    max_steps: int = MAX_STEPS,
) -> KeRatio:
    """Peak kinetic energy of the middle site, bistable over linear chain, for one impact (paper section 3).

    `accuracy` is the wanted relative error of ke_ratio; rtol and atol are for method="rk45" only.
    `certify=False` skips the error estimate and a third or more of the work. Raises ValueError naming all bad arguments.
    """
    task, integrator = Task(N, zeta_T, M_over_M0, V_over_V0), choose(method, accuracy, rtol, atol, max_steps)
    columns = {name: np.array([getattr(task, name)]) for name in PARAMETERS}
    row = results_of(columns, integrator, certify)[0]
    values = {name: row[name].item() for name in RESULT.names or ()}
    return KeRatio(**values | {name: values[name].decode() for name in ("method", "status")})


def ke_ratios(
    tasks: Any,
    accuracy: float = 1e-3,
    method: str = "auto",
    rtol: float | None = None,
    atol: float | None = None,
    *,
    certify: bool = True,
    max_steps: int = MAX_STEPS,
) -> NDArray[np.void]:
    """The same for many tasks: a structured array (n,) of dtype kernel.ke.RESULT, in the tasks' order.

    `tasks`: a mapping, structured array or data frame with the columns N, zeta_T, M_over_M0, V_over_V0, or an array
    (n, 4) in that order. A task whose parameters break a rule gets the status "bad_input"; the others are computed.
    """
    integrator = choose(method, accuracy, rtol, atol, max_steps)
    columns = _columns(tasks)
    bad = [i for i, values in enumerate(zip(*columns.values(), strict=True)) if _broken(values)]
    good = np.setdiff1d(np.arange(len(columns["N"])), bad)
    results = np.zeros(len(columns["N"]), RESULT)
    for name in NUMBERS[: ERROR + 1]:
        results[name] = np.nan
    results["status"] = WORDS[BAD_INPUT]
    results[good] = results_of({name: values[good] for name, values in columns.items()}, integrator, certify)
    return results


def _columns(tasks: Any) -> dict[str, NDArray[Any]]:
    if isinstance(tasks, Mapping) or hasattr(tasks, "columns") or getattr(getattr(tasks, "dtype", None), "names", None):
        found = {name: np.atleast_1d(np.asarray(tasks[name])) for name in PARAMETERS}
    else:
        table = np.asarray(tasks)
        if table.ndim != 2 or table.shape[1] != len(PARAMETERS):
            raise ValueError(f"tasks: must have the columns {', '.join(PARAMETERS)}, got shape {table.shape}")
        found = dict(zip(PARAMETERS, table.T, strict=True))
    return dict(zip(found, np.broadcast_arrays(*found.values()), strict=True))


def _broken(values: Sequence[Any]) -> bool:
    N, *others = (value.item() for value in values)
    N = int(N) if isinstance(N, float) and N.is_integer() else N  # an array of floats has no whole numbers
    return any(broken_rule(name, value) for name, value in zip(PARAMETERS, (N, *others), strict=True))


def results_of(columns: Mapping[str, NDArray[Any]], integrator: Integrator, certify: bool) -> NDArray[np.void]:
    """ke_ratios for parameters and an integrator that are checked already."""
    N = np.ascontiguousarray(columns["N"], np.int64)
    zeta_T, M, V = (np.ascontiguousarray(columns[name], np.float64) for name in PARAMETERS[1:])
    numbers = np.empty((len(N), len(COLUMNS)))
    _solve(N, zeta_T, M, V, integrator, integrator.companion(), certify, numbers)
    results = np.empty(len(N), RESULT)
    for name, column in zip(COLUMNS[:SITES], numbers.T, strict=False):
        results[name] = column
    results["site_evaluations"] = numbers[:, SITES]
    results["chaotic"] = numbers[:, ERROR] > integrator.chaotic_from
    results["error"] = np.maximum(results["error"], integrator.least_error)  # nan stays nan
    results["status"] = np.array(WORDS, "S16")[numbers[:, STATUS].astype(int)]
    results["method"] = np.array(METHOD_WORDS, "S16")[numbers[:, METHOD].astype(int)]
    return results


@jit
def _solve(
    N: NDArray[np.int64],
    zeta_T: Array,
    M_over_M0: Array,
    V_over_V0: Array,
    integrator: Integrator,
    companion: Integrator,
    certify: bool,
    out: Array,
) -> None:
    """One row of COLUMNS per task, without returning to Python in between."""
    for i in range(N.shape[0]):
        M, V, n = M_over_M0[i] * M0, V_over_V0[i] * V0, N[i]
        bistable = peak_of(n, zeta_T[i], M, V, True, integrator)
        linear = peak_of(n, zeta_T[i], M, V, False, integrator)
        row = out[i]
        row[:] = np.nan
        row[METHOD], row[STATUS] = bistable.method, max(bistable.status, linear.status)
        row[STEPS], row[EVALUATIONS], row[SITES] = 0.0, 0.0, 0.0
        _count(row, bistable)
        _count(row, linear)
        if bistable.status == DONE:
            row[BISTABLE], row[T_BISTABLE] = bistable.speed**2 / (n * M * V * V), bistable.t / n
        if linear.status == DONE:
            row[LINEAR], row[T_LINEAR] = linear.speed**2 / (n * M * V * V), linear.t / n
        if row[STATUS] != DONE:
            continue
        ratio = _ratio(bistable, linear)
        if not ratio > 0.0:
            row[STATUS] = NOT_FINITE
            continue
        row[RATIO] = ratio
        if certify:
            bistable = peak_of(n, zeta_T[i], M, V, True, companion)
            linear = peak_of(n, zeta_T[i], M, V, False, companion)
            _count(row, bistable)
            _count(row, linear)
            row[ERROR] = abs(_ratio(bistable, linear) / ratio - 1.0)


@jit
def _count(row: Array, peak: Peak) -> None:
    row[STEPS] += peak.steps
    row[EVALUATIONS] += peak.evaluations
    row[SITES] += peak.site_evaluations


@jit
def _ratio(bistable: Peak, linear: Peak) -> float:
    """ke_bistable / ke_linear; TE cancels."""
    below = linear.speed**2
    return bistable.speed**2 / below if below > 0.0 else np.nan
