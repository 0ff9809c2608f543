"""Work against precision: what a digit of ke_ratio costs by every method, on tasks of the paper's domain or a table."""

import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.paper.numbers import DOMAIN
from kernel.ke import results_of
from kernel.lattice import PAPER_MODEL, Model
from kernel.method import ATOL_OVER_RTOL, Integrator, choose
from sweep.errors import InputError
from sweep.plan.cost import predict_work
from sweep.schema import inputs_of
from sweep.store import table
from sweep.tell.audit import SECONDS_MAX, its_model

REFERENCE = choose("rk45", rtol=1e-12, atol=1e-15)
CONDITION_MAX = 100.0  # condition number below which a task is well-conditioned (docs/accuracy.md)
UNDAMPED_SHARE = 0.125  # share of tasks with zeta_T = 0; the others are logarithmic in all four parameters
TASKS_MAX = 10_000
DRAWN_OVER_TASKS = 10  # rows drawn of a table for each task that is wanted: where more are chaotic, fewer are measured
TARGETS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
CERTIFIED, UNCERTIFIED, RK45 = "auto, error estimated", "auto, certify = false", "rk45"
ODE45_RTOL = 1e-3  # ode45's defaults: RelTol 1e-3, AbsTol 1e-6
_HEAD = f"{'':35}ms/task   on average  evaluations/time   error 50 %      90 %     worst"
Progress = Callable[[str, int, int], None]  # told what is being done, how much of it, and of how much
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


class Sample(NamedTuple):
    """The tasks on which the trade is measured, and what else was drawn on the way."""

    tasks: pd.DataFrame  # with their converged ke_ratio
    ill_conditioned: int
    dear: int = 0  # rows of a table whose reference would take longer than SECONDS_MAX
    model: Model = PAPER_MODEL


def settings() -> list[Setting]:
    """All points, line by line."""
    auto = [(name, name == CERTIFIED, target) for name in (CERTIFIED, UNCERTIFIED) for target in TARGETS]
    points = [Setting(name, target, choose("auto", target, certify=certify), certify) for name, certify, target in auto]
    return points + [
        Setting(RK45, rtol, choose("rk45", rtol=rtol, atol=ATOL_OVER_RTOL * rtol), False) for rtol in RTOLS
    ]


def unseen(what: str, done: int, of: int) -> None:
    """The Progress of who does not look."""


def sample(tasks: int, seed: int, progress: Progress = unseen) -> Sample:
    """So many random tasks of the paper's domain."""
    _check(tasks, seed)
    return Sample(*_well_conditioned(_draws(np.random.default_rng(seed)), tasks, PAPER_MODEL, progress))


def sample_of(path: Path, tasks: int, seed: int, progress: Progress = unseen) -> Sample:
    """At most so many done rows of a table; one that is flagged as chaotic counts as ill-conditioned."""
    _check(tasks, seed)
    with table.reading(path) as file:
        model, rows = its_model(file), _some_rows(file, tasks * DRAWN_OVER_TASKS, np.random.default_rng(seed))
    names = inputs_of(rows.dtype)
    too_dear = predict_work({name: rows[name] for name in names}, REFERENCE, True, model) > SECONDS_MAX
    drawn = [(bool(row["chaotic"]), {name: row[name].item() for name in names}) for row in rows[~too_dear]]
    found, left_out = _well_conditioned(drawn, tasks, model, progress)
    dear = int(too_dear.sum())
    if found.empty:
        why = f"{left_out} are chaotic or ill-conditioned, {dear} would take more than {SECONDS_MAX:g} s"
        raise InputError(f"{path}: has no row with a converged ratio to measure errors by: of {len(rows)} drawn {why}")
    return Sample(found, left_out, dear, model)


def _check(tasks: int, seed: int) -> None:
    if not (1 <= tasks <= TASKS_MAX and seed >= 0):
        raise InputError(f"--tasks must be from 1 to {TASKS_MAX} and --seed at least 0, got {tasks} and {seed}")


def _some_rows(file: Any, count: int, rng: np.random.Generator) -> NDArray[np.void]:
    """So many done rows of a table in random order, or all; of a large one only those are ever held."""
    parts, keys = list[NDArray[np.void]](), np.empty(0)
    for done in table.done_rows(file):
        keys = np.concatenate([keys, rng.random(len(done))])
        order = np.argsort(keys)[:count]
        parts, keys = [np.concatenate([*parts, done])[order]], keys[order]
    if not len(keys):
        raise InputError(f"{file.filename}: has no done row to measure errors by")
    return parts[0]


def _well_conditioned(
    drawn: Iterable[tuple[bool, dict[str, float]]], tasks: int, model: Model, progress: Progress
) -> tuple[pd.DataFrame, int]:
    """The first so many well-conditioned tasks with their converged ke_ratio, and how many others came before.

    With each task comes whether it is known to be chaotic, which saves the runs that would show it.
    """
    found, left_out = list[dict[str, float]](), 0
    progress("references", 0, tasks)
    for chaotic, task in drawn:
        ratio = np.nan if chaotic else _converged(task, model)
        if np.isfinite(ratio):
            found.append(task | {"ke_ratio": ratio})
        else:
            left_out += 1
        progress("references", len(found), tasks)
        if len(found) == tasks:
            break
    return pd.DataFrame(found), left_out


def _converged(task: dict[str, float], model: Model) -> float:
    """The ke_ratio of a well-conditioned task, nan of another one."""
    row = results_of(_columns(task), REFERENCE, certify=True, model=model)[0]
    return float(row["ke_ratio"]) if row["condition"] < CONDITION_MAX else np.nan


def _draws(rng: np.random.Generator) -> Iterator[tuple[bool, dict[str, float]]]:
    """Random tasks of the paper's domain, without end."""
    while True:
        task = {name: float(np.exp(rng.uniform(*np.log(ends)))) for name, ends in DOMAIN.items()}
        undamped = rng.random() < UNDAMPED_SHARE
        yield False, task | {"N": round(task["N"]), "zeta_T": 0.0 if undamped else task["zeta_T"]}


def _columns(task: dict[str, float], copies: int = 1) -> dict[str, NDArray[np.float64]]:
    return {name: np.full(copies, value) for name, value in task.items() if name != "ke_ratio"}


def measure(tasks: pd.DataFrame, setting: Setting, model: Model = PAPER_MODEL) -> dict[str, object]:
    """One point of the picture: quantiles of error, processor time and work over the tasks.

    Errors are relative to the references, infinite for a task that fails. Work is force evaluations per cell transit
    time, of both chains and, with an error estimate, of its runs too.
    """
    rows = [_measure_one(task, setting, model) for task in _records(tasks)]
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
    return [dict(zip(tasks.columns, row, strict=True)) for row in tasks.to_numpy(np.float64).tolist()]


def _measure_one(task: dict[str, float], setting: Setting, model: Model) -> tuple[float, float, float]:
    """The relative error, the seconds and the force evaluations per cell transit time of one task."""
    for copies in (1, COPIES):
        start = time.thread_time()  # processor time: other processes do not count
        result = results_of(_columns(task, copies), setting.integrator, setting.certify, model=model)[0]
        seconds = (time.thread_time() - start) / copies
        if seconds > TIMED_ALONE:
            break
    error = abs(float(result["ke_ratio"]) / task["ke_ratio"] - 1.0)
    per_time = float(result["evaluations"]) / (task.get("t_end", model.t_end) * task["N"])
    return error if np.isfinite(error) else np.inf, seconds, per_time


def _quantile(values: NDArray[np.float64], q: float) -> float:
    return float(np.quantile(values, q, method="inverted_cdf"))


def tradeoff(tasks: pd.DataFrame, model: Model = PAPER_MODEL, progress: Progress = unseen) -> pd.DataFrame:
    """All points, one row each; every method is compiled before it is timed."""
    everything, points = settings(), list[dict[str, object]]()
    for setting in everything:
        _measure_one(_records(tasks)[0], setting, model)
    for setting in everything:
        progress("methods timed", len(points), len(everything))
        points.append(measure(tasks, setting, model))
    return pd.DataFrame(points)


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
