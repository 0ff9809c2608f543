"""ke_ratio of one task: both chains, their peaks, an error estimate."""

import math
from dataclasses import dataclass

from kernel import rk45
from kernel.method import MAX_STEPS, RK45, choose
from kernel.model import M0, T_END_OVER_N, V0, make_chain
from kernel.status import DONE, NOT_FINITE, WORDS
from kernel.task import Task


@dataclass(frozen=True)
class KeRatio:
    """What one task gives. Not done: every number that is not known is nan."""

    ke_ratio: float  # ke_bistable / ke_linear; below 1 the bistable chain protects better
    ke_bistable: float  # peak kinetic energy of the middle site over the initial total energy TE
    ke_linear: float  # the same of the comparative linear chain
    t_peak_bistable: float  # when, over N
    t_peak_linear: float
    error: float  # estimated relative error of ke_ratio; nan where not asked for
    chaotic: bool  # the number is not determined by the inputs (always False where error is not asked for)
    method: str
    steps: int  # accepted steps of all integrations
    evaluations: int  # force evaluations of the whole chain, of all integrations
    status: str  # "done", or why not (kernel.status.SENTENCES)


# The companion run that the error is estimated from: tolerances this much looser cost half as much.
COMPANION = 32.0
# Two runs can agree by chance; the estimate is never below this many relative tolerances.
FLOOR = 3.0
# Where two tolerances differ by this much, inputs that differ by rounding would too (paper domain: finds 94 % of the
# tasks whose ke_ratio moves by more than 1e-3 when V moves by 1e-6, with about 6 % false alarms).
CHAOTIC_ERROR = 3e-3


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
    `certify=False` skips the error estimate and a third of the work. Raises ValueError naming every bad argument.
    """
    return ke_ratio_of(Task(N, zeta_T, M_over_M0, V_over_V0), choose(method, accuracy, rtol, atol, max_steps), certify)


def ke_ratio_of(task: Task, integrator: RK45, certify: bool = True) -> KeRatio:
    """The same for parameters and an integrator that are checked already."""
    bistable, linear = (_integrate(task, integrator, bistable=law) for law in (True, False))
    runs = [bistable, linear]
    error = math.nan
    status = bistable.status or linear.status
    ratio = _ratio(bistable, linear)
    if status == DONE and not ratio > 0.0:
        status = NOT_FINITE
    if status == DONE and certify:
        runs += (_integrate(task, integrator.looser(COMPANION), bistable=law) for law in (True, False))
        error = max(abs(_ratio(runs[2], runs[3]) / ratio - 1.0), FLOOR * integrator.rtol)
    return KeRatio(
        ke_ratio=ratio if status == DONE else math.nan,
        ke_bistable=_ke_of(task, bistable),
        ke_linear=_ke_of(task, linear),
        t_peak_bistable=bistable.t_peak / task.N if bistable.status == DONE else math.nan,
        t_peak_linear=linear.t_peak / task.N if linear.status == DONE else math.nan,
        error=error,
        chaotic=error > CHAOTIC_ERROR,
        method=integrator.name,
        steps=sum(run.steps for run in runs),
        evaluations=sum(run.evaluations for run in runs),
        status=WORDS[status],
    )


def _integrate(task: Task, integrator: RK45, *, bistable: bool) -> rk45.Outcome:
    chain = make_chain(task.N, task.zeta_T, task.M_over_M0, bistable=bistable)
    speed = task.V_over_V0 * V0
    t_end = T_END_OVER_N * task.N
    return rk45.integrate(chain, speed, integrator.rtol, integrator.atol, integrator.max_steps, t_end)


def _ratio(bistable: rk45.Outcome, linear: rk45.Outcome) -> float:
    """ke_bistable / ke_linear; TE cancels."""
    below = linear.peak_speed**2
    return bistable.peak_speed**2 / below if below > 0.0 else math.nan


def _ke_of(task: Task, run: rk45.Outcome) -> float:
    """Peak of v_mid^2/2 over TE = N M V^2/2; nan where the run did not finish."""
    if run.status != DONE:
        return math.nan
    return run.peak_speed**2 / (task.N * task.M_over_M0 * M0 * (task.V_over_V0 * V0) ** 2)
