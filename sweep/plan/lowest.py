"""A search for the lowest number of every cell: all candidates are screened, those tried and computed that can be it.

Neither screening nor trying estimates its error. So the cell's own tasks tell it: how far screening is off those that
were tried too, how far trying is off those that were computed too and are not chaotic. A candidate comes further as
long as it could be the lowest if it were off BEYOND times as far as the worst of them (as logarithms). Screening that
ends early may miss a later, higher crest and so tell too little; that cannot hide the lowest. So only by how much it
told too much counts. Each round of a cell takes the lowest of those: first it tries, twice as many as the round
before, what may be lower than everything tried or computed, and what lies beside the lowest; only then it computes
what may be lower than everything computed.
Chaotic rows are no lowest, as in `analysis.best`: a cell that has no others is computed as a whole.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.plan import search
from sweep.plan.axis import rounded
from sweep.plan.rounds import Rounds
from sweep.plan.search import screening_ends, usable
from sweep.plan.tasks import Ids, Tasks
from sweep.schema import DONE

# Both as python -m tests.search_constants fits them. Of 684 cells of random grids (seeds 1 to 12) none is more than 2 %
# above the lowest of its grid, also with 1.2 or 2, and with 4 or 16; of 676 of the coarse figure 8 none.
BEYOND = 1.5  # a factor of logarithms
FIRST_ROUND = 8  # candidates of a cell that are tried first: fewer tell too little of the errors
COMPUTED_PER_MORE = 4  # a quarter as many at once as were computed: one by one would let ranks wait
CENTRE, SCREENED, TRIED, COMPUTED = range(4)  # how far a candidate has come: itself screened, its neighbours too, ..
Reduce = Callable[..., NDArray[np.float64]]


def around(values: Sequence[float], distance: float) -> list[float]:
    """Every value, then what lies at a relative distance below and above it; to 12 digits, as those of a grid."""
    factors = (1.0, 1.0 - distance, 1.0 + distance)
    return [rounded(value * factor) for value in values for factor in factors]


class Lowest(Rounds):
    """What is known of every cell, and which of its tasks are screened or computed next.

    A candidate is one task; where neighbours count too (`robust`), it is the task and those around it.
    """

    def __init__(
        self, tasks: Tasks, over: Sequence[str], of: str, around: int = 1, reduce: Reduce = np.max, first: int = 1
    ) -> None:
        """`over`: the axes over which the lowest is looked for; a cell is one combination of the others.

        around: how many neighbouring values of each of these axes make one candidate, itself first; reduce: what of
        their numbers counts; first: how many of a candidate's tasks must be screened to bound it from below.
        """
        self.of, self._reduce, self._first = of, reduce, first
        self.screens = screening_ends(of)
        self._ids = blocks(tasks, over, around)  # (cells, candidates, tasks of a candidate)
        super().__init__(tasks, self._ids)
        # How many candidates lie along each axis.
        self._shape = tuple(len(values) // around for name, values in tasks.axes.items() if name in over)
        shape, flat = self._ids.shape, len(tasks)
        # By COMPUTE, SCREEN, TRY, of every task; of chaotic ones too.
        self._number = np.full((search.KINDS, flat), np.nan)
        self._firm = np.zeros(flat, np.bool_)
        self._stage = np.full(shape[:2], CENTRE)
        self._round = np.full(shape[0], FIRST_ROUND)  # candidates of the next round to try

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Failed rows give no number."""
        self._number[search.COMPUTE, ids] = np.where(rows["status"] == DONE, rows[self.of], np.nan)
        self._firm[ids] = np.isfinite(usable(rows, self.of)) & rows["checked"]
        self.learn(ids)

    def tell_seen(self, orders: Ids, values: NDArray[np.float64]) -> None:
        """What was not screened or tried well can be anything."""
        self._number.ravel()[orders] = values
        self.learn(orders)

    def orders(self, cell: int) -> Ids:
        ids, stage, tasks = self._ids[cell], self._stage[cell], len(self.tasks)
        screened = np.concatenate([ids[:, : self._first].ravel(), ids[stage >= SCREENED].ravel()])
        tried, computed = ids[stage >= TRIED].ravel(), ids[stage == COMPUTED].ravel()
        return np.concatenate([computed, search.SCREEN * tasks + screened, search.TRY * tasks + tried])

    def step(self, cell: int) -> bool:
        ids, stage = self._ids[cell], self._stage[cell]
        computed, screened, tried = self._number[:, ids]  # (candidates, tasks of each)
        firm, waits = (stage == COMPUTED) & self._firm[ids].all(axis=1), stage == TRIED
        seen, looked = self._reduce(screened, axis=1), self._reduce(tried, axis=1)
        seen = np.where(stage == CENTRE, self._reduce(screened[:, : self._first], axis=1), seen)
        best = np.where(firm, self._reduce(computed, axis=1), np.inf)
        lowest = np.fmin(best, np.where(waits, looked, np.inf))
        off = _off(screened, tried, stage >= TRIED, self.screens < math.inf)
        chosen = _below(lowest.min(), seen, off, stage < TRIED)[: self._round[cell]]
        if len(chosen) or len(chosen := self._beside(int(lowest.argmin()), stage)):
            whole = ids.shape[1] == self._first  # there is nothing more to screen
            stage[chosen] = np.where(whole, TRIED, stage[chosen] + 1)
            self._round[cell] *= 2
            return True
        off = _off(tried, computed, firm)
        more = max(1, np.count_nonzero(stage == COMPUTED) // COMPUTED_PER_MORE)
        stage[chosen := _below(best.min(), looked, off, waits)[:more]] = COMPUTED
        return bool(len(chosen))

    def _beside(self, lowest: int, stage: NDArray[np.int64]) -> Ids:
        """Those of the candidates next to the lowest, along one axis, that are not yet tried."""
        place = np.array(np.unravel_index(lowest, self._shape))
        steps = np.concatenate([np.eye(len(place), dtype=np.int64), -np.eye(len(place), dtype=np.int64)])
        inside = [tuple(near) for near in place + steps if (near >= 0).all() and (near < self._shape).all()]
        ids = np.array([np.ravel_multi_index(near, self._shape) for near in inside], np.int64)
        return ids[stage[ids] < TRIED]


def _off(
    seen: NDArray[np.float64], found: NDArray[np.float64], where: NDArray[np.bool_], too_high: bool = False
) -> float:
    """By how much what was seen may be off, or too high, as a logarithm, told by those of which more was found."""
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.log(seen[where] / found[where])
        off = np.maximum(off, 0.0) if too_high else np.abs(off)
    off = off[~np.isnan(off)]
    return float(BEYOND * off.max()) if off.size else np.inf


def _below(best: Any, seen: NDArray[np.float64], off: float, where: NDArray[np.bool_]) -> Ids:
    """The candidates, from the lowest seen up, that may be below `best`, if what was seen may be off so far."""
    with np.errstate(invalid="ignore", over="ignore"):
        least = np.where(seen > 0, seen * np.exp(-off), seen * np.exp(off))
    rest = np.flatnonzero(where & ~(least >= best))
    return rest[np.argsort(np.where(np.isnan(seen), -np.inf, seen)[rest], kind="stable")]  # nothing excludes a nan


def blocks(tasks: Tasks, over: Sequence[str], around: int) -> Ids:
    """The numbers of the tasks, as (cells, candidates, tasks of a candidate)."""
    outer, inner, near, shape = list[int](), list[int](), list[int](), list[int]()
    for name, values in tasks.axes.items():
        (inner if name in over else outer).append(len(shape))
        shape.append(len(values) // around if name in over else len(values))
        if name in over:
            near.append(len(shape))
            shape.append(around)
    ids = np.arange(len(tasks)).reshape(shape).transpose(*outer, *inner, *near)
    candidates = int(np.prod([shape[k] for k in inner], dtype=np.int64))
    return np.ascontiguousarray(ids.reshape(-1, candidates, around ** len(near)))
