"""ke_ratio of many tasks or of one: both chains, their peaks, an error estimate.

A task is computed by itself: its bits depend neither on its neighbours in the batch nor on who computes it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.certify import ScaledTask, certify, error_of_quantity, pair_of, unjudged
from kernel.columns import RESULT, bad_rows, columns_of, columns_of_quantity, result_type, whole
from kernel.integrate import Peak
from kernel.jit import jit
from kernel.laws import PAPER
from kernel.method import MAX_STEPS, METHOD_WORDS, Integrator, choose
from kernel.model import M0, V0, Array
from kernel.status import BAD_INPUT, DONE, WORDS
from kernel.task import PARAMETERS as PARAMETERS
from kernel.task import Task, check, gathered

# What the compiled loop writes of them: text as a code.
CODED = np.dtype(
    [
        (name, "f8" if RESULT[name].kind == "f" else "i8")
        for name in RESULT.names or ()
        if name not in (*PARAMETERS, "checked")
    ]
)


WORDS_OF = {"method": METHOD_WORDS, "status": WORDS}
NO_QUANTITIES: Mapping[str, Any] = {}


@dataclass(frozen=True)
class KeRatio:
    """What one task gives; what each field is stands at `ke_ratio`, which makes it."""

    ke_ratio: float
    ke_bistable: float
    ke_linear: float
    t_peak_bistable: float
    t_peak_linear: float
    error: float
    condition: float
    chaotic: bool | None
    checked: bool
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

    Parameters
    ----------
    N : int
        Number of unit cells, 2 to 10 000; 200.0 is 200.
    zeta_T : float
        Bulk damping ratio, 0 to 10.
    M_over_M0 : float
        Impactor mass over the nominal one (0.159 of the chain's mass), 0.01 to 100.
    V_over_V0 : float
        Impact speed over the nominal one (0.26 long-wave sound speeds), 0.01 to 20.
    accuracy : float
        Wanted relative error of ke_ratio, 1e-8 to 0.1.
    method : str
        "auto" chooses by accuracy and physics; "rk45" is Dormand-Prince 5(4), the paper's.
    rtol, atol : float, optional
        Relative (1e-13 to 0.1) and absolute (above 0) tolerance of a step, with method="rk45" only; without them they
        follow from `accuracy`.
    certify : bool
        False leaves out error and check for chaos, and most of the work; above an accuracy of 1e-3 it takes looser
        steps, too.
    max_steps : int
        Tried steps of one integration, 1 to 10**15, after which the status is "step_budget".

    Returns
    -------
    KeRatio
        `ke_ratio`, below 1 where the bistable chain protects better; `ke_bistable` and `ke_linear`, the largest
        v^2 / 2 of the middle site over the impactor's energy; `t_peak_bistable` and `t_peak_linear`, when that is, in
        cell transit times over N (0 to 2.25); `error`, the estimated relative error of ke_ratio; `condition`,
        the relative change of ke_ratio over that of its inputs and of the first state, estimated; `chaotic`, whether
        that exceeds 1000 (neighbours at 1e-6 differ by more than 1e-3), then ke_ratio is within `spread_low` to
        `spread_high`; `checked`, whether the condition number is known, else `chaotic` is None; `method` that
        integrated the bistable chain; `steps`, `evaluations` of the force, `site_evaluations`, of all integrations;
        `status`, "done" or why not. What is not known is nan.

    Raises
    ------
    ValueError
        Naming every argument that breaks its rule, with the rule and the value.

    Examples
    --------
    >>> import kernel
    >>> r = kernel.ke_ratio(N=20, zeta_T=4e-4, M_over_M0=2, V_over_V0=2)
    >>> print(f"{r.ke_ratio:.2f} {r.status} {r.chaotic}")
    2.15 done False
    """
    task, integrator, _ = gathered(
        lambda: Task(N, zeta_T, M_over_M0, V_over_V0),
        lambda: choose(method, accuracy, rtol, atol, max_steps, certify=certify),
        lambda: check({"certify": certify}),
    )
    row = results_of({name: np.array([getattr(task, name)]) for name in PARAMETERS}, integrator, bool(certify))[0]
    told = {name: row[name].item() for name in RESULT.names or () if name not in PARAMETERS}
    return KeRatio(**told | {"chaotic": told["chaotic"] if told["checked"] else None})


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
    """ke_ratio of many tasks, each with the bits that `ke_ratio` gives.

    Parameters
    ----------
    tasks : mapping, structured array, data frame, array (n, 4), or sequence of Task
        The columns N, zeta_T, M_over_M0, V_over_V0, each a number or (n,), or these four in that order; units and
        ranges are those of `ke_ratio`. N may be floats without a fraction.
    accuracy, method, rtol, atol, certify, max_steps
        As of `ke_ratio`.

    Returns
    -------
    structured array (n,)
        In the tasks' order, ready for pandas.DataFrame: the inputs N (int64), zeta_T, M_over_M0, V_over_V0, then the
        results of `ke_ratio`; `method` and `status` are str. `chaotic` is False where not `checked`. A task whose
        parameters break a rule has the status "bad_input" and no numbers; the others are computed. Its inputs are as
        given, but for an N that is no whole number, which such a column cannot hold: it is -1.

    Raises
    ------
    ValueError
        Naming every argument that breaks its rule, every column that is missing, of another length or shape, or holds
        something else than numbers.

    Examples
    --------
    >>> import kernel
    >>> rows = kernel.ke_ratios({"N": [10, 1], "zeta_T": 1e-3, "M_over_M0": 1, "V_over_V0": 1})
    >>> rows["N"].tolist(), rows["status"].tolist()
    ([10, 1], ['done', 'bad_input'])
    """
    columns, integrator, _ = gathered(
        lambda: columns_of(tasks),
        lambda: choose(method, accuracy, rtol, atol, max_steps, certify=certify),
        lambda: check({"certify": certify}),
    )
    results, bad = np.zeros(len(columns["N"]), RESULT), bad_rows(columns)
    for name in RESULT.names or ():
        if RESULT[name].kind == "f":
            results[name] = np.nan
    for name in PARAMETERS:
        results[name] = whole(columns[name]) if name == "N" else columns[name]
    results["status"] = WORDS[BAD_INPUT]
    results[~bad] = results_of({name: values[~bad] for name, values in columns.items()}, integrator, bool(certify))
    return results


def results_of(
    columns: Mapping[str, NDArray[Any]],
    integrator: Integrator,
    certify: bool,
    disturbance: float = 0.0,
    spring: Any = PAPER,
    quantities: Mapping[str, Any] = NO_QUANTITIES,
) -> NDArray[np.void]:
    """ke_ratios for parameters and an integrator that are checked already.

    disturbance: relative, of M, V and the first velocities of the sites; with `certify` it must be 0. spring: a law of
    kernel.laws. quantities: those of kernel.quantities that are asked for, by name; their columns follow the others.
    """
    N = np.ascontiguousarray(columns["N"], np.int64)
    zeta_T, M, V = (np.ascontiguousarray(columns[name], np.float64) for name in PARAMETERS[1:])
    coded, more = np.empty(len(N), CODED), np.empty((len(N), len(quantities), 4))
    asked = tuple(quantities.values())
    solve(N, zeta_T, M * M0, V * V0, spring, asked, integrator, certify, disturbance, coded, more)
    results = np.empty(len(N), result_type(*quantities))
    for name in PARAMETERS:
        results[name] = columns[name]
    for name in CODED.names or ():
        results[name] = np.array(WORDS_OF[name], RESULT[name])[coded[name]] if name in WORDS_OF else coded[name]
    results["checked"] = np.isfinite(results["condition"])
    for k, name in enumerate(quantities):
        for column, values in zip(columns_of_quantity(name), more[:, k].T, strict=True):
            results[column] = values
    return results


@jit
def solve(
    N: NDArray[np.int64],
    zeta_T: Array,
    M: Array,
    V: Array,
    spring: Any,
    quantities: Any,
    integrator: Integrator,
    certified: bool,
    disturbance: float,
    out: NDArray[np.void],
    more: Array,
) -> None:
    """One row of CODED per task, without returning to Python in between; disturbance: as kernel.certify.pair_of.

    more (n, quantities, 4): receives their columns.
    """
    work = np.zeros(3)
    for i in range(N.shape[0]):
        task = ScaledTask(N[i], zeta_T[i], M[i], V[i], spring, quantities)
        work[:] = 0.0
        first = pair_of(task, disturbance, integrator, work)
        verdict = certify(task, first, integrator, work) if certified and first.status == DONE else unjudged(first)
        best, row = verdict.best, out[i]
        row["ke_ratio"] = best.ratio
        row["ke_bistable"], row["t_peak_bistable"] = _energy_and_time(best.bistable, task.N)
        row["ke_linear"], row["t_peak_linear"] = _energy_and_time(best.linear, task.N)
        row["error"], row["condition"], row["chaotic"] = verdict.error, verdict.condition, verdict.chaotic
        row["spread_low"], row["spread_high"] = verdict.low, verdict.high
        row["steps"], row["evaluations"], row["site_evaluations"] = work[0], work[1], work[2]
        row["method"], row["status"] = best.bistable.method, verdict.status
        for k in range(len(quantities)):
            chain, linear = best.bistable.largest[k], best.linear.largest[k]
            more[i, k, 0], more[i, k, 1] = chain, linear
            more[i, k, 2] = chain / linear if linear > 0.0 else np.nan
            more[i, k, 3] = error_of_quantity(verdict, k)
            if best.status != DONE:
                more[i, k] = np.nan


@jit
def _energy_and_time(peak: Peak, N: int) -> tuple[float, float]:
    """Of the peak, over TE and over N; nan where the run did not finish."""
    return (peak.KE, peak.run.t / N) if peak.run.status == DONE else (np.nan, np.nan)
