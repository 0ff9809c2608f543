"""Runs solvers over their ladders: error and time of each setting, within a budget."""

import sys
from time import perf_counter

import numpy as np

from .common import BATCH, TARGETS, TASKS, Point, Task, neighbours, reached

SMALL = Task(10, 1e-3, 1.0, 1.0)  # compiles whatever compiles at its first call
ENOUGH = TARGETS[-1] / 3.0  # tighter settings cannot be the fastest that reach a target
REPEATS, SETTLED = 5, 0.5  # more repeats than this many, or after this many seconds, do not change the minimum
ONCE = 3.0  # a run that takes longer than this many seconds is not repeated
GROWTH = 1.8  # how much longer the next setting takes, at most, as a rule
LONG, LONG_JUDGED = 500, 5  # on chains longer than this fewer neighbours: a single one for slow peers


def fits(solver, name):
    """Whether a solver takes part in a task: slow ones only where that is asked, F is for the fast ones."""
    return solver.longest >= TASKS[name].N and (name != "F" or not solver.slow)


def chosen(solver, name, reference, few):
    """The tasks to run, and the (positions, exact ratios) to judge by."""
    count = LONG_JUDGED if TASKS[name].N > LONG and not solver.slow else solver.judged
    count = 1 if solver.slow and (few or TASKS[name].N > LONG) else min(count, 3) if few else count
    indices = list(reference[name])[:count]
    exact = np.array([reference[name][i] for i in indices])
    tasks = neighbours(name)
    if solver.batch and affordable(solver, tasks):
        return tasks, indices, exact
    return [tasks[i] for i in indices], list(range(len(indices))), exact


def affordable(solver, tasks):
    """Whether whole batches fit the budget."""
    solver.run(tasks[:1], solver.ladder[0])
    return BATCH * solver.run(tasks[:1], solver.ladder[0])[1] < solver.budget / 4.0


def repeated(solver, tasks, setting):
    """Ratios, the minimum of seconds per task, the seconds spent, and how many repeats."""
    ratios, best = solver.run(tasks, setting)
    spent, repeats = best * len(tasks), 1
    while (repeats < REPEATS and spent < SETTLED) or (repeats == 1 and spent < ONCE):
        seconds = solver.run(tasks, setting)[1]
        best, spent, repeats = min(best, seconds), spent + seconds * len(tasks), repeats + 1
    return ratios, best, spent, repeats


def climb(solver, name, reference, *, few=False):
    """The points of one solver on one task, loose to tight, until well below the last target or out of budget."""
    tasks, judged, exact = chosen(solver, name, reference, few)
    left, points = solver.budget * (0.3 if few else 1.0), []
    for setting in solver.ladder:
        ratios, seconds, spent, repeats = repeated(solver, tasks, setting)
        error = reached(ratios[judged], exact)
        points.append(Point(solver.name, name, setting, error, seconds, len(judged), len(tasks), repeats))
        left -= spent
        if error <= ENOUGH or GROWTH * spent / repeats > left:
            break
    return points


def everything(solvers, names, reference, *, few=False):
    """All points; a solver that breaks down is reported on its line and left."""
    points = []
    for solver in solvers:
        solver.run([SMALL], solver.ladder[0])
        for name in names:
            if fits(solver, name):
                start = perf_counter()
                points += climb(solver, name, reference, few=few)
                print(f"  {solver.name} on {name}: {perf_counter() - start:.1f} s", file=sys.stderr, flush=True)
    return points
