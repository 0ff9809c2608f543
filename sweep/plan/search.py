"""What steers a sweep that does not compute all its rows: it is told what was computed, and asked what is to be next.

The table has a row for every task that a search may ask for. So a task's number follows from the spec, as in any grid.
Which tasks are computed follows from values alone: a search decides where it has all the values that a decision needs,
whatever else it was told, and in whatever order. So neither ranks nor kills change what is asked for.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.method import Integrator, choose, shared_speed
from sweep.plan.tasks import Ids, TaskList, Tasks
from sweep.schema import DONE

# How tasks are screened: as loosely as can be. At 1e-2 it takes twice the time, and as many tasks are misjudged: what
# moves them is not the step but how sensitive they are to anything (measured on the coarse figure 8).
SCREENING = choose("auto", 1e-1, certify=False)
# Where the chain's kinetic energy or its ratio to the linear chain's is looked at, the chain's own run ends after so
# many times what sound takes to the watched site: a third of the paper's run. What comes later can only raise its
# energy, so that screening tells too little, and too much only by its long steps. The linear chain runs to its end: a
# heavy impactor drives its largest crest after the reflection. Until 1.3 screening takes less and trying more, until
# 1.8 the other way round: python -m tests.search_constants fits it.
SCREENED_UNTIL = 1.5
RAISED_LATE = ("ke_ratio", "ke_bistable")  # of which that holds
SPEED = "V_over_V0"
# What an order asks of its task: of n tasks order k asks to compute task k, n + k to screen it, 2 n + k to try it.
COMPUTE, SCREEN, TRY = range(KINDS := 3)


def screening_ends(of: str) -> float:
    """After how many times what sound takes to the watched site, where this column is looked at; inf: as a run."""
    return SCREENED_UNTIL if of in RAISED_LATE else math.inf


def how(asked: int, integrator: Integrator, certify: bool) -> tuple[Integrator, bool]:
    """By which integrator that is done for a sweep's tasks, and whether the result is judged."""
    return SCREENING if asked == SCREEN else integrator, certify and asked == COMPUTE


class Extent(NamedTuple):
    """How much a search computes, known beforehand."""

    first: int  # tasks that are computed in any case
    at_most: int  # and at most; where tasks are screened, as many are
    screens: float = 0.0  # as of the search
    tries: bool = False  # whether at most as many are tried too


def in_words(extent: Extent) -> str:
    """`search, at most 30 tasks`."""
    if not extent.screens:
        return f"search, at most {extent.at_most} tasks"
    return f"search, {extent.at_most} tasks to screen, at most {extent.at_most} {ended(extent.tries)}"


def ended(tries: bool) -> str:
    """What follows screening, where it does."""
    return "tried and computed" if tries else "computed"


class Search:
    """Ask and tell. An order is the number of a task that is to be computed; else it is larger, and asks for less.

    To screen is to run the task loosely, with no estimate of the error, only to see whether it is worth more. To try is
    to run it as tightly as it would be computed, without what judges the result, which takes twice as long again.
    """

    tasks: Tasks  # every task that has a row
    of: str  # the column in which it looks for something
    screens = 0.0  # screening ends after so many times what sound takes to the watched site; 0: nothing is screened

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Take in finished rows, failed ones too."""

    def tell_seen(self, orders: Ids, values: NDArray[np.float64]) -> None:
        """Take in what screening and trying gave for these orders, nan where it failed."""

    def ask(self) -> Ids:
        """The orders that can be given now, ascending, without those given before and those whose result is known."""
        raise NotImplementedError


def usable(rows: NDArray[np.void], of: str) -> NDArray[np.float64]:
    """A column of finished rows, nan where a number is worth nothing: the row failed, or is chaotic."""
    good = (rows["status"] == DONE) & ~rows["chaotic"]
    return np.where(good, rows[of], np.nan)


class Along:
    """The tasks of a grid as lines along one of its axes: line and place of a task, and the other way round."""

    def __init__(self, tasks: Tasks, axis: str) -> None:
        names, lengths = list(tasks.axes), [len(values) for values in tasks.axes.values()]
        at = names.index(axis)
        self.places, self._after = lengths[at], int(np.prod(lengths[at + 1 :], dtype=np.int64))
        self.lines = len(tasks) // self.places

    def where(self, ids: Ids) -> tuple[Any, Any]:
        """Place on its line, and line, of every task."""
        before, rest = np.divmod(ids, self.places * self._after)
        place, after = np.divmod(rest, self._after)
        return place, before * self._after + after

    def ids(self, places: Any, lines: Any) -> Ids:
        """The tasks at these places of these lines."""
        before, after = np.divmod(lines, self._after)
        return np.asarray((before * self.places + places) * self._after + after, np.int64)


def first_alike(tasks: TaskList, ids: Ids, quantities: int) -> Ids:
    """Of each task the first of those that differ from it in speed alone and share a linear chain when screened."""
    if quantities or not isinstance(tasks, Tasks):
        return ids
    _, first, which = np.unique(shared_speed(tasks.axes[SPEED]), return_index=True, return_inverse=True)
    along = Along(tasks, SPEED)
    place, line = along.where(ids)
    return along.ids(first[which.ravel()[place]], line)


def sharing(tasks: TaskList, quantities: int) -> float:
    """How many tasks share a linear chain when screened, in the mean; none do where quantities are observed."""
    if quantities or not isinstance(tasks, Tasks):
        return 1.0
    speeds = tasks.axes[SPEED]
    return len(speeds) / len(np.unique(shared_speed(speeds)))
