"""ke_ratio of many tasks or of one: both chains, their peaks, an error estimate.

A task is computed by itself: its bits depend neither on its neighbours in the batch nor on who computes it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.certify import Impact, Verdict, certify, pair_of
from kernel.jit import jit
from kernel.method import MAX_STEPS, METHOD_WORDS, Integrator, choose
from kernel.model import M0, V0, Array
from kernel.peaks import Peak
from kernel.status import BAD_INPUT, DONE, WORDS
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
        ("chaotic", "?"),  # not determined by the inputs (kernel.certify; False where error is not asked for)
        ("spread_low", "f8"),  # ke_ratio of a chaotic task's neighbours lies from here
        ("spread_high", "f8"),  # to here; nan of a task that is not chaotic
        ("method", "S16"),  # the integrator of the bistable chain
        ("steps", "i8"),  # accepted steps of all integrations
        ("evaluations", "i8"),  # force evaluations of the chain, of all integrations
        ("site_evaluations", "i8"),  # the same, counting only the sites that the wave had reached
        ("status", "S16"),  # "done", or why not (kernel.status.SENTENCES)
    ]
)
# What the compiled loop writes, one row per task; the last three are codes.
FLOATS = tuple(name for name in RESULT.names or () if RESULT[name].kind == "f")
COUNTS = ("steps", "evaluations", "site_evaluations")
COLUMNS = (*FLOATS, *COUNTS, "chaotic", "method", "status")


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
    spread_low: float
    spread_high: float
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
    `certify=False` skips error and flag, and most of the work; above 3e-3 it takes looser steps, too. ValueError names
    every bad argument.
    """
    task = Task(N, zeta_T, M_over_M0, V_over_V0)
    integrator = choose(method, accuracy, rtol, atol, max_steps, certify=certify)
    numbers = _solved({name: np.array([getattr(task, name)]) for name in PARAMETERS}, integrator, certify)
    *floats, steps, evaluations, site_evaluations, chaotic, method_code, status = numbers[0].tolist()
    return KeRatio(
        **dict(zip(FLOATS, floats, strict=True)),
        steps=int(steps),
        evaluations=int(evaluations),
        site_evaluations=int(site_evaluations),
        chaotic=bool(chaotic),
        method=METHOD_WORDS[int(method_code)],
        status=WORDS[int(status)],
    )


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
    (n, 4) in that order, or a sequence of Task. A task whose parameters break a rule gets the status "bad_input"; the
    others are computed.
    """
    integrator = choose(method, accuracy, rtol, atol, max_steps, certify=certify)
    columns = _columns(tasks)
    bad = [i for i, values in enumerate(zip(*columns.values(), strict=True)) if _broken(values)]
    good = np.setdiff1d(np.arange(len(columns["N"])), bad)
    results = np.zeros(len(columns["N"]), RESULT)
    for name in FLOATS:
        results[name] = np.nan
    results["status"] = WORDS[BAD_INPUT]
    results[good] = results_of({name: values[good] for name, values in columns.items()}, integrator, certify)
    return results


def _columns(tasks: Any) -> dict[str, NDArray[Any]]:
    if isinstance(tasks, Mapping) or hasattr(tasks, "columns") or getattr(getattr(tasks, "dtype", None), "names", None):
        try:
            found = {name: np.atleast_1d(np.asarray(tasks[name])) for name in PARAMETERS}
        except (KeyError, ValueError) as error:
            raise ValueError(f"tasks: must have the columns {', '.join(PARAMETERS)}, lacks {error}") from None
    else:
        table = np.asarray([[getattr(t, name) for name in PARAMETERS] if isinstance(t, Task) else t for t in tasks])
        if table.ndim != 2 or table.shape[1] != len(PARAMETERS):
            raise ValueError(f"tasks: must have the columns {', '.join(PARAMETERS)}, got shape {table.shape}")
        found = dict(zip(PARAMETERS, table.T, strict=True))
    return dict(zip(found, np.broadcast_arrays(*found.values()), strict=True))


def _broken(values: Sequence[Any]) -> bool:
    N, *others = (getattr(value, "item", lambda value=value: value)() for value in values)
    N = int(N) if isinstance(N, float) and N.is_integer() else N  # an array of floats has no whole numbers
    return any(broken_rule(name, value) for name, value in zip(PARAMETERS, (N, *others), strict=True))


def results_of(columns: Mapping[str, NDArray[Any]], integrator: Integrator, certify: bool) -> NDArray[np.void]:
    """ke_ratios for parameters and an integrator that are checked already."""
    numbers = _solved(columns, integrator, certify)
    results, column = np.empty(len(numbers), RESULT), dict(zip(COLUMNS, numbers.T, strict=True))
    for name in (*FLOATS, *COUNTS, "chaotic"):
        results[name] = column[name]
    for name, words in (("status", WORDS), ("method", METHOD_WORDS)):
        results[name] = np.array(words, "S16")[column[name].astype(int)]
    return results


def _solved(columns: Mapping[str, NDArray[Any]], integrator: Integrator, certify: bool) -> Array:
    """The numbers of COLUMNS, (n, 14)."""
    N = np.ascontiguousarray(columns["N"], np.int64)
    zeta_T, M, V = (np.ascontiguousarray(columns[name], np.float64) for name in PARAMETERS[1:])
    numbers = np.empty((len(N), len(COLUMNS)))
    solve(N, zeta_T, M * M0, V * V0, integrator, certify, numbers)
    return numbers


@jit
def solve(
    N: NDArray[np.int64], zeta_T: Array, M: Array, V: Array, integrator: Integrator, certified: bool, out: Array
) -> None:
    """One row of COLUMNS per task, without returning to Python in between."""
    work = np.zeros(3)
    for i in range(N.shape[0]):
        task = Impact(N[i], zeta_T[i], M[i], V[i])
        work[:] = 0.0
        first = pair_of(task, 0.0, integrator, work)
        verdict = Verdict(first.status, first, np.nan, np.nan, False, np.nan, np.nan)
        if certified and first.status == DONE:
            verdict = certify(task, first, integrator, work)
        best = verdict.best
        row = out[i]
        row[0] = best.ratio
        row[1], row[3] = _energy_and_time(best.bistable, task.N)
        row[2], row[4] = _energy_and_time(best.linear, task.N)
        row[5], row[6], row[7] = verdict.error, verdict.low, verdict.high
        row[8], row[9], row[10] = work[0], work[1], work[2]
        row[11], row[12], row[13] = 1.0 if verdict.chaotic else 0.0, best.bistable.method, verdict.status


@jit
def _energy_and_time(peak: Peak, N: int) -> tuple[float, float]:
    """Of the peak, over TE and over N; nan where the run did not finish."""
    return (peak.KE, peak.t / N) if peak.status == DONE else (np.nan, np.nan)
