"""Work against precision: what a digit of ke_ratio costs by every method, on random tasks of the paper's domain."""

import time
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.errors import InputError
from analysis.paper.numbers import DOMAIN
from kernel.ke import results_of
from kernel.method import ATOL_OVER_RTOL, Integrator, choose
from kernel.task import T_END_OVER_N
from sweep.schema import PARAMETERS

REFERENCE = choose("rk45", rtol=1e-12, atol=1e-15)
# A task is well-conditioned if this relative shift of V changes ke_ratio by less than this, relative.
NEIGHBOUR_SHIFT, NEIGHBOUR_CHANGE_MAX = 1e-6, 1e-4
UNDAMPED_SHARE = 0.125  # share of tasks with zeta_T = 0; the others are logarithmic in all four parameters
TASKS_MAX = 10_000
COLUMNS = (*PARAMETERS, "ke_ratio")
TARGETS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
CERTIFIED, UNCERTIFIED, RK45 = "auto, error estimated", "auto, certify = false", "rk45"
ODE45_RTOL = 1e-3  # ode45's defaults: RelTol 1e-3, AbsTol 1e-6
_HEAD = f"{'':35}ms/task   on average  evaluations/time   error 50 %      90 %     worst"
TIMED_ALONE = 2e-3  # s: a task that takes longer is timed alone; a shorter one COPIES at a time, as clocks are coarse
COPIES = 8


class Setting(NamedTuple):
    """One point of the picture."""

    method: str  # one of the three above: a line of the picture
    setting: float  # target of auto, rtol of rk45
    integrator: Integrator
    certify: bool

    @property
    def ode45(self) -> bool:
        """Whether these are ode45's defaults."""
        return self.method == RK45 and self.setting == ODE45_RTOL


def settings() -> list[Setting]:
    """All points, line by line."""
    auto = [(name, name == CERTIFIED, target) for name in (CERTIFIED, UNCERTIFIED) for target in TARGETS]
    points = [Setting(name, target, choose("auto", target, certify=certify), certify) for name, certify, target in auto]
    return points + [
        Setting(RK45, rtol, choose("rk45", rtol=rtol, atol=ATOL_OVER_RTOL * rtol), False) for rtol in RTOLS
    ]


def sample(tasks: int, seed: int) -> tuple[pd.DataFrame, int]:
    """Well-conditioned random tasks with their converged ke_ratio, and how many others were drawn on the way."""
    if not (1 <= tasks <= TASKS_MAX and seed >= 0):
        raise InputError(f"--tasks must be from 1 to {TASKS_MAX} and --seed at least 0, got {tasks} and {seed}")
    rng, found, drawn = np.random.default_rng(seed), list[dict[str, float]](), 0
    while len(found) < tasks:
        task = _draw(rng)
        here, there = (_ratio(task | {"V_over_V0": task["V_over_V0"] * x}) for x in (1.0, 1.0 + NEIGHBOUR_SHIFT))
        drawn += 1
        if abs(there / here - 1.0) < NEIGHBOUR_CHANGE_MAX:
            found.append(task | {"ke_ratio": here})
    return pd.DataFrame(found), drawn - tasks


def _draw(rng: np.random.Generator) -> dict[str, float]:
    task = {name: float(np.exp(rng.uniform(*np.log(ends)))) for name, ends in DOMAIN.items()}
    undamped = rng.random() < UNDAMPED_SHARE
    return task | {"N": round(task["N"]), "zeta_T": 0.0 if undamped else task["zeta_T"]}


def _ratio(task: dict[str, float]) -> float:
    return float(results_of(_columns(task), REFERENCE, certify=False)["ke_ratio"][0])


def _columns(task: dict[str, float], copies: int = 1) -> dict[str, NDArray[np.float64]]:
    return {name: np.full(copies, task[name]) for name in PARAMETERS}


def measure(tasks: pd.DataFrame, setting: Setting) -> dict[str, object]:
    """One point of the picture: quantiles of error, processor time and work over the tasks.

    Errors are relative to the references, infinite for a task that fails. Work is force evaluations per cell transit
    time, of both chains and, with an error estimate, of its runs too.
    """
    rows = [_measure_one(task, setting) for task in _records(tasks)]
    error, seconds, evaluations = np.array(rows).T
    return {
        "method": setting.method,
        "setting": setting.setting,
        "ode45_defaults": setting.ode45,
        "error_50": _quantile(error, 0.5),
        "error_90": _quantile(error, 0.9),
        "error_100": float(error.max()),
        "ms_50": 1e3 * _quantile(seconds, 0.5),
        "ms_mean": 1e3 * float(seconds.mean()),
        "evaluations_per_time_50": _quantile(evaluations, 0.5),
        "tasks": len(rows),
        "failed": int(np.isinf(error).sum()),
    }


def _records(tasks: pd.DataFrame) -> list[dict[str, float]]:
    return [dict(zip(COLUMNS, row, strict=True)) for row in tasks[list(COLUMNS)].to_numpy().tolist()]


def _measure_one(task: dict[str, float], setting: Setting) -> tuple[float, float, float]:
    """The relative error, the seconds and the force evaluations per cell transit time of one task."""
    for copies in (1, COPIES):
        start = time.thread_time()  # processor time: other processes do not count
        result = results_of(_columns(task, copies), setting.integrator, setting.certify)[0]
        seconds = (time.thread_time() - start) / copies
        if seconds > TIMED_ALONE:
            break
    error = abs(float(result["ke_ratio"]) / task["ke_ratio"] - 1.0)
    per_time = float(result["evaluations"]) / (T_END_OVER_N * task["N"])
    return error if np.isfinite(error) else np.inf, seconds, per_time


def _quantile(values: NDArray[np.float64], q: float) -> float:
    return float(np.quantile(values, q, method="inverted_cdf"))


def tradeoff(tasks: pd.DataFrame) -> pd.DataFrame:
    """All points, one row each; every method is compiled before it is timed."""
    everything = settings()
    for setting in everything:
        _measure_one(_records(tasks)[0], setting)
    return pd.DataFrame([measure(tasks, setting) for setting in everything])


def cost_of_a_digit(line: pd.DataFrame) -> tuple[float, float]:
    """By which factor a tenth of the 90 % error takes longer, for the median task and for the mean of all tasks.

    It follows from a power law through the points of one method.
    """
    fit = line[np.isfinite(line["error_90"]) & (line["error_90"] > 0)]
    slopes = (np.polyfit(np.log10(fit["error_90"]), np.log10(fit[ms]), 1)[0] for ms in ("ms_50", "ms_mean"))
    median, mean = (10.0 ** -float(slope) for slope in slopes)
    return median, mean


def headlines(points: pd.DataFrame) -> list[str]:
    """One line per point, then what a tenth of the error costs by each method."""
    lines = [_point(points.iloc[i]) for i in range(len(points))]
    costs = [_decade(str(name), line) for name, line in points.groupby("method", sort=False)]
    return [_HEAD, *lines, *costs]


def _point(row: "pd.Series[Any]") -> str:
    knob = "rtol" if row["method"] == RK45 else "target"
    name = f"{row['method']} at {knob} {row['setting']:.0e}{' (ode45)' if row['ode45_defaults'] else ''}"
    times = f"{row['ms_50']:7.2g}{row['ms_mean']:13.2g}{row['evaluations_per_time_50']:18.3g}"
    return f"{name:35}{times}{row['error_50']:13.1e}{row['error_90']:10.1e}{row['error_100']:10.1e}"


def _decade(name: str, line: pd.DataFrame) -> str:
    median, mean = cost_of_a_digit(line)
    return f"a tenth of the 90 % error costs {median:.2g} times as long ({mean:.2g} times on average) by {name}"
