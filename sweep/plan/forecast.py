"""The predicted work of a whole sweep: every task of a small sweep is looked at, a sample of a large one."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.method import Integrator
from sweep.plan.batches import computing_ranks, wall_seconds
from sweep.plan.chains import share_until
from sweep.plan.cost import predict_all
from sweep.plan.parts import Predict
from sweep.plan.search import SCREEN, how, sharing
from sweep.plan.tasks import Ids, Listed, TaskList, Tasks

EXACT_MAX = 1 << 17  # tasks: up to so many each is predicted, in a fifth of a second; of more, a sample
SAMPLED_PART = 4  # of EXACT_MAX, one part of so many is the sample
COARSE_VALUES = 6  # of each axis: their grid is searched for the longest task, which a sample may miss


@dataclass(frozen=True)
class Forecast:
    """Predicted work, in core seconds."""

    tasks: int  # that may be computed
    looked_at: int  # of them; `tasks` where the prediction holds every one
    seconds: float  # core seconds of all
    standard_error: float  # of `seconds`, that comes from looking at a sample; 0 where there is none
    longest: float  # seconds of the longest task that was looked at
    work: NDArray[np.float64] = field(repr=False)  # (looked_at,) seconds

    def wall(self, ranks: int) -> float:
        """Seconds on so many ranks; of a sample, as if the last rank ended half of the longest task after the first."""
        if self.looked_at == self.tasks:
            return wall_seconds(self.work, ranks)
        shares = computing_ranks(ranks)
        return max(self.longest, self.seconds / shares + 0.5 * self.longest * (1.0 - 1.0 / shares))


def forecast(tasks: Tasks | Listed, computed: int, predict: Predict, exact_max: int = EXACT_MAX) -> Forecast:
    """Predict the work of `computed` of the tasks, as if they were spread evenly over all of them.

    `computed`: all tasks, or the most that a search can ask for; `predict`: the seconds of tasks. Of more than
    `exact_max` tasks a sample of a quarter as many is looked at, and a coarse grid that only shows the longest. The
    same sweep always gives the same sample.
    """
    looked = computed if computed <= exact_max else max(2, exact_max // SAMPLED_PART)
    work = predict(_spread(len(tasks), computed, looked))
    if looked == computed:
        return Forecast(computed, looked, float(work.sum()), 0.0, float(work.max()), work)
    each = computed / looked
    ends = predict(tasks.coarse(COARSE_VALUES))
    # One task of each stratum: what two neighbours differ by estimates the variance, a little too high.
    pairs = work[: looked // 2 * 2].reshape(-1, 2)
    error = each * float(np.sqrt(np.sum((pairs[:, 0] - pairs[:, 1]) ** 2)))
    return Forecast(computed, looked, each * float(work.sum()), error, float(max(work.max(), ends.max())), work)


def predict_asked(
    tasks: TaskList,
    ids: Ids,
    asked: int,
    integrator: Integrator,
    certify: bool,
    model: Any,
    quantities: int,
    screens: float,
) -> NDArray[np.float64]:
    """Predicted work of what is asked of these tasks (`sweep.plan.search`): to compute, screen or try them.

    integrator, certify: of the sweep; `model`, `quantities`: as of `sweep.plan.cost.predict_work`; screens: of the
    search. What is screened or tried has all quantities too.
    """
    share = share_until(screens, model, sharing(tasks, quantities)) if asked == SCREEN else 1.0
    return share * predict_all(tasks, ids, *how(asked, integrator, certify), model, quantities)


def with_screening(computed: Forecast, screened: Forecast) -> Forecast:
    """The work of a search that screens, or tries, so many tasks, besides computing at most so many of them."""
    return replace(
        computed,
        seconds=computed.seconds + screened.seconds,
        standard_error=float(np.hypot(computed.standard_error, screened.standard_error)),
        work=np.append(computed.work, screened.work),
    )


def _spread(rows: int, computed: int, looked: int) -> Ids:
    """The numbers of `looked` tasks: one of each of as many equal strata of all rows, drawn unless all are meant."""
    if looked == computed:
        return np.linspace(0, rows - 1, looked).astype(np.int64)
    width = rows / looked
    drawn = np.random.default_rng(0).random(looked)
    return np.minimum(((np.arange(looked) + drawn) * width).astype(np.int64), rows - 1)
