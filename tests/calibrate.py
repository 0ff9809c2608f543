"""Fits the cost model to the kernel as it is now.

    python -m tests.calibrate [--tasks 3000] [--write]
    python -m tests.calibrate --specs SPEC ...

Draws tasks over the paper's domain and beyond, times them with and without certification, and their companions (core
seconds, the best of two), fits the laws of a run and the expected work of refinement. Judges both on a fresh draw: the
ratio of the sums and the scatter. --write puts the coefficients into sweep/plan/laws.py. --specs only judges what
`sweep plan` tells of whole sweeps, by computing every task of them.
"""

import argparse
import re
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from kernel.ke import results_of
from kernel.lattice import PAPER_MODEL
from kernel.method import (
    AUTO,
    DORMAND_PRINCE,
    EXPLICIT,
    IMPLICIT,
    PROBE_ACCURACY,
    SWITCH,
    Integrator,
    choose,
    looser,
)
from kernel.task import T_END_OVER_N
from sweep.plan import cost, laws
from sweep.plan.laws import Law
from sweep.plan.spec import read_spec
from sweep.tell import report

LAWS = Path(laws.__file__)
TARGETS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
RK45_SHARE = 0.2  # of the tasks; half at rtol 1e-3 .. 1e-8, half at targets from which "auto" is rk45 with weak dampers
TIGHT = 3e-7  # such a target
OTHER_TIMES = 0.3  # of the tasks: else nothing tells the steps that resolve the impact from the later ones
LEAST = 1e-9
LEAST_SECONDS = 3e-3  # a call of the kernel costs 0.1 ms, which no task of a sweep pays for itself
PAPER_TIME = np.array([T_END_OVER_N])
MOST_SITES = 1e5  # beyond it a pass costs the same at any N that there is, and the coefficient says nothing
TINY = 1e-15  # coefficients below it are none
EXPONENT = 3.0  # none is as large
FITTED = ("EXPLICIT", "IMPLICIT", "AUTO_RK45", "RK45")  # each a _LAW of sweep/plan/laws.py
MORES = {"EXPLICIT": ("EXPLICIT",), "IMPLICIT": ("IMPLICIT", "AUTO_RK45"), "RK45": ("RK45",)}
PER_LINE = 7  # numbers of `more` in sweep/plan/laws.py: of "auto" three whole lines
NOISE = 0.15  # of a task's seconds: what is left beyond runs and checks counts as refinement from here


class Drawn(NamedTuple):
    """One task and what it took."""

    columns: dict[str, np.ndarray]
    asked: Integrator
    integrator: Integrator  # of the first certified run
    first: float  # its seconds
    companion: float  # of the companion
    all: float  # with certification


def draw(rng: np.random.Generator) -> tuple[dict[str, np.ndarray], Integrator]:
    """A random task; a tenth are undamped. Some run for another time."""
    zeta_T = 0.0 if rng.random() < 0.1 else 10.0 ** rng.uniform(-5, 0)
    values = (int(10 ** rng.uniform(0.7, 2.75)), zeta_T, 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-1, 1))
    columns = {name: np.array([value]) for name, value in zip(cost.PARAMETERS, values, strict=True)}
    if rng.random() < OTHER_TIMES:
        columns["t_end"] = np.array([rng.uniform(0.5, 6.0)])
    if rng.random() < RK45_SHARE:
        if values[0] * zeta_T < SWITCH and rng.random() < 0.5:
            return columns, choose("auto", 10 ** rng.uniform(-8, np.log10(TIGHT)))
        rtol = 10 ** rng.uniform(-8, -3)
        return columns, choose("rk45", rtol=rtol, atol=1e-3 * rtol)
    return columns, choose("auto", float(rng.choice(TARGETS)))


def timed(columns: dict[str, np.ndarray], integrator: Integrator, certify: bool) -> float:
    """Core seconds of one task, the best of two; of short ones many at once, as in a sweep."""
    best, copies = np.inf, int(np.ceil(LEAST_SECONDS / predicted(columns, integrator, certify)))
    many = {name: np.repeat(values, copies) for name, values in columns.items()}
    for _ in range(2):
        start = time.thread_time()
        results_of(many, integrator, certify)
        best = min(best, time.thread_time() - start)
    return float(best) / copies


def predicted(columns: dict[str, np.ndarray], integrator: Integrator, certify: bool) -> float:
    """Core seconds of one task."""
    return float(cost.predict_work(columns, integrator, certify, PAPER_MODEL)[0])


def sample(count: int, seed: int, longest: float) -> list[Drawn]:
    """Tasks that are predicted to take at most `longest` seconds."""
    rng, drawn = np.random.default_rng(seed), []
    while len(drawn) < count:
        columns, integrator = draw(rng)
        if predicted(columns, integrator, certify=False) < longest:
            begun = next(x for which, x in cost.begun_with(columns, integrator) if which[0])
            runs = (begun, False), (looser(begun), False), (integrator, True)
            drawn.append(Drawn(columns, integrator, begun, *(timed(columns, *run) for run in runs)))
    return drawn


def kind(task: Drawn) -> str:
    """The law that a task follows."""
    if task.integrator.kind != AUTO:
        return "RK45"
    laws = {EXPLICIT: "EXPLICIT", DORMAND_PRINCE: "AUTO_RK45", IMPLICIT: "IMPLICIT"}
    return laws[cost.methods(task.columns, task.integrator)[0]]


def fit_law(tasks: list[Drawn], start: Law, first: float) -> Law:
    """Least squares of the logarithm, robust, then scaled to the right sum. Companions are runs like any other."""
    columns = {name: np.concatenate([task.columns[name] for task in tasks * 2]) for name in cost.PARAMETERS}
    columns["crossings"] = np.concatenate([task.columns.get("t_end", PAPER_TIME) for task in tasks * 2])
    integrators = [task.integrator for task in tasks] + [looser(task.integrator) for task in tasks]
    a = np.array([x.accuracy if x.kind == AUTO else x.rtol for x in integrators])
    seconds = np.array([task.first for task in tasks] + [task.companion for task in tasks])
    positive = np.array([name in ("c", "impact", "sites", "start", "stiff", "coarse") for name in Law._fields])
    free = np.array([value > 0 or name not in ("stiff", "coarse") for name, value in start._asdict().items()])

    def law(x: np.ndarray) -> Law:
        values = np.array(start)
        values[free] = x
        return Law(*np.where(positive & free, np.exp(np.where(positive, values, 0.0)), values).tolist())

    def residual(x: np.ndarray) -> np.ndarray:
        return np.log(cost.by_law(columns, law(x), a, first) / seconds)

    values = np.array(start)
    x = np.where(positive, np.log(np.maximum(values, 1e-300)), values)[free]
    most = {"impact": MOST_SITES, "sites": MOST_SITES, "coarse": 1.0}
    highest = np.where(positive, [np.log(most.get(name, 1.0)) for name in Law._fields], EXPONENT)[free]
    lowest = np.where(positive, np.log(1e-300), -EXPONENT)[free]
    x = np.clip(x, lowest + 1.0, highest - 0.1)
    best = law(least_squares(residual, x, bounds=(lowest, highest), loss="soft_l1").x)
    scale = seconds.sum() / cost.by_law(columns, best, a, first).sum()
    return best._replace(c=best.c * scale, start=best.start * scale, stiff=best.stiff * scale)


def fit_more(tasks: list[Drawn]) -> np.ndarray:
    """Poisson regression with a first run's seconds as exposure: its sum over the sample is right by construction."""
    X = np.array([np.concatenate(list(cost.features(task.columns, task.integrator))) for task in tasks])
    first, companion, whole = np.array([[task.first, task.companion, task.all] for task in tasks]).T
    asked = np.array([task.integrator.kind != AUTO for task in tasks])
    probes = np.array(
        [
            2.0 * cost.first_run(task.columns, task.integrator._replace(kind=AUTO, accuracy=PROBE_ACCURACY))[0]
            for task in tasks
        ]
    )
    compared = np.array([cost.COMPARED if kind(task) == "EXPLICIT" else 1.0 for task in tasks])
    rest = whole - first - compared * companion - np.where(asked, probes, 0.0)
    run = np.array([cost.first_run(task.columns, task.integrator)[0] for task in tasks])
    more = np.where(rest > NOISE * whole, rest, LEAST)
    weight = run**-0.7  # the many cheap tasks tell as much about the law as the few expensive ones
    exposure, beta = run * weight, np.zeros(X.shape[1])
    beta[0] = np.log((more * weight).sum() / exposure.sum())
    for _ in range(50):
        mean = exposure * np.exp(np.clip(X @ beta, *cost.MORE_RANGE))
        ridge = 1e-2 * mean.sum() / len(mean) * np.eye(len(beta))
        step = np.linalg.solve(X.T @ (X * mean[:, None]) + ridge, X.T @ (more * weight - mean))
        beta += step / max(1.0, float(np.abs(step).max()))
    return beta


def judge(tasks: list[Drawn]) -> None:
    """Print predicted over real sums, and the scatter of single tasks."""
    for name in (*FITTED, "all"):
        some = [task for task in tasks if name in ("all", kind(task))]
        told = []
        for certify in (False, True):
            real = np.array([task.all if certify else task.first for task in some])
            expected = np.array(
                [predicted(task.columns, task.asked if certify else task.integrator, certify) for task in some]
            )
            scatter = np.exp(np.std(np.log(expected / real)))
            told.append(f"{expected.sum() / real.sum():.2f} (scatter {scatter:.2f})")
        print(f"{name:9} {len(some):5} tasks: predicted over real, one run {told[0]}, certified {told[1]}")


def judge_spec(path: Path) -> None:
    """Print predicted and real core seconds of a whole sweep."""
    spec, text = read_spec(path)
    tasks, accuracy = spec.task_list(), spec.accuracy
    columns, integrator = tasks.columns(np.arange(len(tasks))), accuracy.integrator()
    predicted, model = report.plan(spec, text, path.parent)["core_hours"] * 3600, spec.kernel_model() or PAPER_MODEL
    results_of({name: values[:1] for name, values in columns.items()}, integrator, accuracy.certify, model=model)
    start = time.thread_time()
    results_of(columns, integrator, accuracy.certify, model=model)
    real = time.thread_time() - start
    print(
        f"{path}: {len(tasks)} tasks, predicted {predicted:.2f} core seconds, real {real:.2f}: {predicted / real:.2f}"
    )


def written(fitted: dict[str, Law], mores: dict[str, np.ndarray]) -> str:
    """sweep/plan/laws.py with these coefficients."""
    text = LAWS.read_text()
    for name, law in fitted.items():
        numbers = ", ".join(f"{x:.4g}".replace("e+", "e") if abs(x) > TINY else "0" for x in law)
        text = re.sub(rf"^{name}_LAW = .*$", f"{name}_LAW = Law({numbers})", text, flags=re.MULTILINE)
    text = text[: text.index("EXPLICIT_MORE = (")]
    for name, more in mores.items():
        lines = [more[first : first + PER_LINE] for first in range(0, len(more), PER_LINE)]
        numbers = "".join(f"    {', '.join(f'{x:.4f}' for x in line)},\n" for line in lines)
        text += f"{name}_MORE = (\n{numbers})\n"
    return f"{text}# fmt: on\n"


def main() -> None:
    """Draw, fit, judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", type=int, default=3000)
    parser.add_argument("--longest", type=float, default=0.1, help="predicted seconds of a first run")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--specs", type=Path, nargs="+", default=[])
    args = parser.parse_args()
    results_of(draw(np.random.default_rng(0))[0], choose(), certify=True)  # compiles
    for path in args.specs:
        judge_spec(path)
    if args.specs:
        return
    tasks = sample(args.tasks, 1, args.longest)
    fresh = sample(args.tasks // 3, 2, args.longest)
    print("as it is, on a fresh draw")
    judge(fresh)
    fitted = {
        name: fit_law(
            [t for t in tasks if kind(t) == name], getattr(laws, f"{name}_LAW"), laws.FIRST_SITES.get(name, np.inf)
        )
        for name in FITTED
    }
    for name, law in fitted.items():
        setattr(cost, f"{name}_LAW", law)
    usual = [task for task in tasks if "t_end" not in task.columns]
    mores = {name: fit_more([t for t in usual if kind(t) in kinds]) for name, kinds in MORES.items()}
    for name, more in mores.items():
        setattr(cost, f"{name}_MORE", more)
    print("fitted anew, on the same fresh draw")
    judge(fresh)
    if args.write:
        LAWS.write_text(written(fitted, mores))


if __name__ == "__main__":
    main()
