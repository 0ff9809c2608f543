"""The longest stable step of every method on one bistable chain, measured."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kernel import rk45
from kernel.method import ATOL_OVER_RTOL
from kernel.model import Chain
from kernel.simd import DOUBLE
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import REFERENCE_ACCURACY, ExplicitRule, ImplicitRule, explicit_rule
from kernel.status import DONE
from kernel.task import T_END_OVER_N
from kernel.watch import new_watch

METHODS = ("explicit", "implicit", "rk45")
STEP_MAX, STEP_MIN = 2.0, 2.0**-7  # cell transit times; longer and shorter steps are not tried
BISECTIONS = 4  # of the factor of two between a stable step and an unstable one: the border is known to 5 %
LOOSEST_RTOL = 0.1  # of rk45: a looser answer has no digit
SUBSTEPS_MAX = 32  # of the contact, that a run may take per step of STEP_MIN


def longest_steps(chain: Chain, V: float) -> NDArray[np.float64]:
    """The longest stable step of each of METHODS, in cell transit times; nan where it is below STEP_MIN.

    For a splitting it is the longest fixed step with which a run stays bounded and gains no energy, the contact
    resolved as usual. For rk45, whose step control shortens every step that would blow up, it is the mean step at
    LOOSEST_RTOL.
    """
    resolved, t_end = explicit_rule(chain, REFERENCE_ACCURACY), T_END_OVER_N * chain.N
    budget = int(SUBSTEPS_MAX * t_end / STEP_MIN)

    def explicit(h: float) -> bool:
        rule = ExplicitRule(math.inf, h, resolved.eta, resolved.parts, resolved.fade)
        return bool(run_explicit(chain, V, rule, rule, budget, 0.0, new_watch(()), DOUBLE).status == DONE)

    def implicit(h: float) -> bool:
        rule = ImplicitRule(math.inf, h, h, 0.0, 0.0, h)
        return bool(run_implicit(chain, V, rule, rule, budget, new_watch(())).status == DONE)

    budget_of_rk45 = int(t_end / STEP_MIN)
    run = rk45.integrate(chain, V, LOOSEST_RTOL, ATOL_OVER_RTOL * LOOSEST_RTOL, budget_of_rk45, t_end, new_watch(()))
    mean = t_end / run.steps if run.status == DONE else math.nan
    return np.array([_longest(explicit), _longest(implicit), mean])


def _longest(stable: Callable[[float], bool]) -> float:
    """Halve the step until it is stable, then bisect; from above, as a run that blows up ends early."""
    high = low = STEP_MAX
    while not stable(low):
        high, low = low, 0.5 * low
        if low < STEP_MIN:
            return math.nan
    for _ in range(BISECTIONS if low < high else 0):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low
