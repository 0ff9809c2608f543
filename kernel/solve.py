"""The compiled loops over many tasks: one row of CODED for each, without returning to Python in between."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.certify import Verdict, certify, error_of_quantity, unjudged
from kernel.columns import RESULT
from kernel.extrapolate import first_of, plain_pair
from kernel.integrate import Peak, peak_of
from kernel.jit import jit
from kernel.method import Integrator
from kernel.model import Array, Lattice, frequency_of, lattice_chain, linear_chain
from kernel.pairs import ScaledTask, counted, paired
from kernel.status import DONE
from kernel.task import PARAMETERS

# What the loops write of the columns of a result: text as a code.
CODED = np.dtype(
    [
        (name, "f8" if RESULT[name].kind == "f" else "i8")
        for name in RESULT.names or ()
        if name not in (*PARAMETERS, "checked")
    ]
)


@jit
def solve(
    N: NDArray[np.int64],
    zeta_T: Array,
    M: Array,
    V: Array,
    lattice: Lattice,
    quantities: Any,
    integrator: Integrator,
    certified: bool,
    disturbance: float,
    out: NDArray[np.void],
    more: Array,
) -> None:
    """One row of CODED per task, without returning to Python in between; disturbance: as kernel.pairs.beside.

    more (n, quantities, 4): receives their columns.
    """
    work, frequency = np.zeros(3), frequency_of(lattice)
    for i in range(N.shape[0]):
        task = ScaledTask(N[i], zeta_T[i], M[i], V[i], lattice, quantities)
        work[:] = 0.0
        if certified:
            verdict = certify(task, first_of(task, integrator), work)
        else:
            verdict = unjudged(plain_pair(task, disturbance, integrator, work, True))
        best = verdict.best
        _write(out[i], verdict, work, task.N * frequency)
        for k in range(len(quantities)):
            chain, linear = best.bistable.largest[k], best.linear.largest[k]
            more[i, k, 0], more[i, k, 1] = chain, linear
            more[i, k, 2] = chain / linear if linear != 0.0 else np.nan
            more[i, k, 3] = error_of_quantity(verdict, k)
            if best.status != DONE:
                more[i, k] = np.nan


@jit
def screen(
    N: NDArray[np.int64],
    zeta_T: Array,
    M: Array,
    V: Array,
    shared_V: Array,
    lattice: Lattice,
    integrator: Integrator,
    out: NDArray[np.void],
) -> None:
    """One row of CODED per task, not certified; the linear chain is struck at `shared_V` (n,).

    Neighbouring tasks for which that is the same run of the same chain share it. A row is the same whatever the tasks
    beside it are, but for the work that it took.
    """
    work, frequency = np.zeros(3), frequency_of(lattice)
    for i in range(N.shape[0]):
        work[:] = 0.0
        same = i > 0 and N[i] == N[i - 1] and zeta_T[i] == zeta_T[i - 1] and M[i] == M[i - 1]
        if not (same and shared_V[i] == shared_V[i - 1]):
            beside = linear_chain(N[i], zeta_T[i], M[i], lattice)
            linear = counted(peak_of(beside, shared_V[i] / frequency, 0.0, integrator, (), False), work)
        chain = lattice_chain(N[i], zeta_T[i], M[i], lattice)
        bistable = counted(peak_of(chain, V[i] / frequency, 0.0, integrator, (), False), work)
        _write(out[i], unjudged(paired(bistable, linear)), work, N[i] * frequency)


@jit
def _write(row: Any, verdict: Verdict, work: Array, unit: float) -> None:
    """All columns of a row but those of quantities; unit: of time."""
    best = verdict.best
    row["ke_ratio"] = best.ratio
    row["ke_bistable"], row["t_peak_bistable"] = _energy_and_time(best.bistable, unit)
    row["ke_linear"], row["t_peak_linear"] = _energy_and_time(best.linear, unit)
    row["error"], row["condition"], row["chaotic"] = verdict.error, verdict.condition, verdict.chaotic
    row["spread_low"], row["spread_high"] = verdict.low, verdict.high
    row["steps"], row["evaluations"], row["site_evaluations"] = work[0], work[1], work[2]
    row["method"], row["status"] = best.bistable.method, verdict.status


@jit
def _energy_and_time(peak: Peak, unit: float) -> tuple[float, float]:
    """Energy of the peak over TE, and its time over a unit of time; both nan where the run did not finish."""
    return (peak.KE, peak.run.t / unit) if peak.run.status == DONE else (np.nan, np.nan)
