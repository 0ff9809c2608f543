"""The table, the ratios to ours, and their geometric means, as text."""

import math

from .common import TARGETS, TASKS
from .ours import ALONE, BATCHED

MIDDLE = TARGETS[1]
MEANT = "ABCD"  # the tasks of the geometric means
OURS, BOOST = "ours rk45", "Boost.odeint dopri5"


def best(points, solver, task, target):
    """The fastest point of a solver that reaches a target on a task, or None."""
    reaching = [p for p in points if p.solver == solver and p.task == task and p.error <= target]
    return min(reaching, key=lambda p: p.seconds, default=None)


def ratio(points, solver, task, target, base):
    """Time of a solver over that of `base`, or None where one of them does not reach the target."""
    theirs, ours = (best(points, name, task, target) for name in (solver, base))
    return theirs.seconds / ours.seconds if theirs and ours else None


def cell(value, unit=1.0):
    """Three digits, or a dash."""
    return f"{'-' if value is None else format(value * unit, '.3g' if value * unit < 1000 else '.0f'):>9}"


def solvers_of(points):
    """Names in the order of the run."""
    return list(dict.fromkeys(p.solver for p in points))


def block(points, name):
    """One task: a line per solver."""
    task = TASKS[name]
    yield f"{name}: N = {task.N}, M/M0 = {task.M_over_M0:g}, V/V0 = {task.V_over_V0:g}, zeta_T = {task.zeta_T:g}"
    yield f"{'':36}{'ms per task at error':>27}   {'over ours in a batch':>27}   judged on"
    yield f"{'':36}" + "".join(f"{t:9g}" for t in TARGETS) + "   " + "".join(f"{t:9g}" for t in TARGETS)
    for solver in solvers_of(p for p in points if p.task == name):
        found = [best(points, solver, name, target) for target in TARGETS]
        times = "".join(cell(p and p.seconds, 1e3) for p in found)
        ratios = "".join(cell(ratio(points, solver, name, target, BATCHED)) for target in TARGETS)
        judged = next(p for p in points if p.solver == solver and p.task == name)
        yield f"{solver:36}{times}   {ratios}   {judged.judged} of {judged.tasks}"
    yield ""


def geometric(values):
    """Geometric mean."""
    return math.exp(sum(map(math.log, values)) / len(values))


def mean(points, solver, base):
    """Geometric mean of the ratios at 1e-3 and the tasks that it is over."""
    found = {t: r for t in MEANT if (r := ratio(points, solver, t, MIDDLE, base)) is not None}
    if not found:
        return "        -"
    return f"{cell(geometric(found.values()))} ({''.join(found)})"


def rows(points):
    """The same for the documentation."""
    for solver in solvers_of(points):
        yield {
            "": solver,
            "time over ours in a batch": mean(points, solver, BATCHED).strip(),
            "over ours alone": mean(points, solver, ALONE).strip(),
        }


def means(points):
    """How many times slower than ours at 1e-3."""
    yield f"geometric mean at error {MIDDLE:g} of time over that of ours, and the tasks that both reached"
    yield f"{'':36}{'in a batch':>16}{'one alone':>16}"
    for solver in solvers_of(points):
        yield f"{solver:36}{mean(points, solver, BATCHED):>16}{mean(points, solver, ALONE):>16}"
    yield ""


def same_tolerances(points):
    """How many times slower Boost's dopri5 is than our rk45 where both are given the same two tolerances."""
    times = {(p.solver, p.task, p.setting): p.seconds for p in points}
    shared = [(t, s) for solver, t, s in times if solver == OURS and (BOOST, t, s) in times]
    for rtol in sorted({s for _, s in shared}, reverse=True):
        found = {t: times[BOOST, t, rtol] / times[OURS, t, rtol] for t, s in shared if s == rtol and t in MEANT}
        if found:
            ratios = ", ".join(f"{t} {r:.2f}" for t, r in found.items())
            yield f"{BOOST} over {OURS}, both at rtol {rtol:g}: {geometric(found.values()):.2f} ({ratios})"
    yield ""


def text(points, header):
    """The whole report."""
    lines = [*header, ""]
    for name in TASKS:
        if any(p.task == name for p in points):
            lines += block(points, name)
    return "\n".join([*lines, *means(points), *same_tolerances(points)]) + "\n"
