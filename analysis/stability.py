"""The longest stable step of every method on one bistable chain, measured."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kernel import rk45
from kernel.method import ATOL_OVER_RTOL
from kernel.model import T_END_OVER_N, Chain
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import REFERENCE, ExplicitRule, ImplicitRule, explicit_rule
from kernel.status import DONE
from kernel.watch import new_watch

METHODS = ("explicit", "implicit", "rk45")
LONGEST, SHORTEST = 2.0, 2.0**-7  # cell transit times; beyond them nothing is tried
BISECTIONS = 4  # of an octave, in its logarithm: to 5 %
LOOSEST_RTOL = 0.1
SUBSTEPS = 32  # of the contact, that a run of the shortest steps may take beside each of them


def longest_steps(chain: Chain, V: float) -> NDArray[np.float64]:
    """Of each of METHODS, in cell transit times; nan where it is below SHORTEST.

    Of the splittings the longest fixed step with which a run neither leaves the bounds of a sound one nor gains energy,
    the contact resolved as usual. Of rk45, whose step control steps back where it blows up, the mean step at the
    loosest tolerance.
    """
    resolved, t_end = explicit_rule(0.0, REFERENCE), T_END_OVER_N * chain.N
    budget = int(SUBSTEPS * t_end / SHORTEST)

    def explicit(h: float) -> bool:
        rule = ExplicitRule(math.inf, h, resolved.eta, resolved.parts, resolved.calm, resolved.fade)
        return bool(run_explicit(chain, V, rule, budget, 0.0, False, new_watch(())).status == DONE)

    def implicit(h: float) -> bool:
        return bool(run_implicit(chain, V, ImplicitRule(math.inf, h, h, 0.0), budget, new_watch(())).status == DONE)

    run = rk45.integrate(
        chain, V, LOOSEST_RTOL, ATOL_OVER_RTOL * LOOSEST_RTOL, int(t_end / SHORTEST), t_end, new_watch(())
    )
    mean = t_end / run.steps if run.status == DONE else math.nan
    return np.array([_longest(explicit), _longest(implicit), mean])


def _longest(stable: Callable[[float], bool]) -> float:
    """Downwards, as a run that blows up ends early; then between the last two."""
    high = low = LONGEST
    while not stable(low):
        high, low = low, 0.5 * low
        if low < SHORTEST:
            return math.nan
    for _ in range(BISECTIONS if low < high else 0):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low
