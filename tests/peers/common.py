"""What every solver shares: the tasks, the interface, and how error and time are taken.

Fair play: every peer integrates the same equations with a compiled force whose loops are fused as ours are (but for
Octave, whose users vectorise), takes the maximum over continuous time, and is judged by the fastest setting of its
tolerance ladder that reaches an error. Every time is that of both chains of a task, bistable and linear: processor time
of all threads, the same as the clock's on an idle core and hardly touched by what else the machine does.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np

from kernel.laws.bistable import C2, C3
from kernel.laws.hertz import C_IMP
from kernel.laws.units import K_T, LENGTH
from kernel.task import M0, V0, Task

TASKS = {
    "A": Task(50, 4e-4, 2.0, 2.0),
    "B": Task(200, 4e-4, 0.553, 10.0),
    "C": Task(300, 1e-4, 0.3, 3.0),
    "D": Task(100, 0.1, 1.0, 1.0),
    "E": Task(1000, 4e-4, 0.553, 10.0),
    "F": Task(100, 4e-4, 0.553, 10.0),  # E's impact on a chain of 100: what a tenth of the sites costs
}
BATCH = 64  # a task and its neighbours, as a sweep has them
SPREAD = 0.05  # how far M and V of a neighbour are off
TARGETS = (1e-2, 1e-3, 1e-4)
ATOL_OVER_RTOL = 1e-3  # ode45's and scipy's defaults have this ratio

# Rows of one call: the ratios of its tasks, and seconds per task.
Timed = tuple[np.ndarray, float]


class Missing(Exception):  # noqa: N818 - not an error: a peer that is not installed is left out by name
    """Why a peer cannot run here."""


@dataclass(frozen=True)
class Solver:
    """One line of the table: a solver and the settings that its users would try, from loose to tight."""

    name: str
    ladder: Sequence[float]  # relative tolerances or accuracies
    run: Callable[[Sequence[Task], float], Timed]
    judged: int = 16  # on how many neighbours the error is taken; fewer flatter a solver, so only slow ones get fewer
    budget: float = 8.0  # seconds for one task's whole ladder
    batch: bool = False  # wants the whole batch at once
    longest: int = 1000  # the longest chain that it finishes within a budget

    @property
    def slow(self) -> bool:
        """Interpreted, or called back through an interpreter."""
        return self.judged < 16


@dataclass(frozen=True)
class Point:
    """One setting of one solver on one task."""

    solver: str
    task: str
    setting: float
    error: float  # relative error of ke_ratio reached: worst but for the worst tenth (of fewer than ten: the worst)
    seconds: float  # per task, minimum of the repeats
    judged: int  # neighbours that the error is taken on
    tasks: int  # tasks of one run
    repeats: int  # runs


def neighbours(name: str, count: int = BATCH) -> list[Task]:
    """The task itself, then seeded ones whose M and V differ by up to 5 %."""
    task = TASKS[name]
    factors = 1.0 + SPREAD * np.random.default_rng(ord(name)).uniform(-1.0, 1.0, (BATCH, 2))
    factors[0] = 1.0
    return [Task(task.N, task.zeta_T, float(task.M_over_M0 * m), float(task.V_over_V0 * v)) for m, v in factors[:count]]


def parameters(task: Task, *, bistable: bool) -> np.ndarray:
    """[zeta, c2, c3, K, impactor mass, V] of one chain, in the units of kernel.model."""
    c2, c3 = (C2, C3) if bistable else (0.0, 0.0)
    K = C_IMP * math.sqrt(LENGTH) / (K_T * task.N**1.5)
    return np.array([task.N * task.zeta_T, c2, c3, K, task.N * task.M_over_M0 * M0, task.V_over_V0 * V0])


def one_by_one(solve: Callable[[Task, float], float]) -> Callable[[Sequence[Task], float], Timed]:
    """Time `solve(task, setting) -> ke_ratio` over tasks, one after the other."""

    def run(tasks: Sequence[Task], setting: float) -> Timed:
        start = process_time()
        ratios = [solve(task, setting) for task in tasks]
        return np.array(ratios), (process_time() - start) / len(tasks)

    return run


def reached(ratios: np.ndarray, exact: np.ndarray) -> float:
    """The error that all but the worst tenth keep; infinite where a task failed."""
    with np.errstate(invalid="ignore"):
        errors = np.abs(ratios / exact - 1.0)
    return float(np.quantile(np.where(np.isfinite(errors), errors, np.inf), 0.9, method="higher"))
