"""Which integrator, how tight: a value that the compiled code takes as it is."""

import math
from typing import NamedTuple

from kernel.hints import unknown
from kernel.task import broken_rule

AUTO, RK45 = range(2)
METHODS = ("auto", "rk45")
MAX_STEPS = 200_000_000

# ode45's default AbsTol over its default RelTol; the absolute tolerance follows the relative one at this ratio.
ATOL_OVER_RTOL = 1e-3
RTOL_MIN = 1e-13

# Measured on the reference tasks (tests/data/references.csv), so that 95 of 100 well-conditioned ones reach their
# target: "auto" is set to this share of it, and never looser than these. A certified run must be tighter: the looser
# its companion, the more calm tasks look suspicious, which costs more than it saves.
SHARE, LOOSEST, LOOSEST_CERTIFIED = 0.3, 2e-3, 1e-3
# For targets below this "auto" is Dormand-Prince, as are refinements below FINEST_SPLITTING: the force's slope jumps,
# which caps the splitting's order.
SPLITTING_TARGET, FINEST_SPLITTING = 3e-6, 9e-7
RTOL_OVER_ACCURACY = 1e-3

# The companion run, from which the error is estimated, is this much looser.
COMPANION_ACCURACY, COMPANION_RTOL = 10 / 3, 16.0


class Integrator(NamedTuple):
    """A method and how it is set. `choose` makes checked ones."""

    kind: int  # AUTO or RK45
    target: float  # wanted relative error of ke_ratio; infinite where the caller set the tolerances
    accuracy: float  # of "auto": relative error of the peak energy that the steps are chosen for
    rtol: float  # of rk45
    atol: float
    max_steps: int  # tried steps of one run, after which it ends with a status

    def __str__(self) -> str:
        if self.kind == AUTO:
            return f"auto at target {self.target:g}"
        return f"rk45 at rtol {self.rtol:g}, atol {self.atol:g}"


def choose(
    method: str = "auto",
    accuracy: float = 1e-3,
    rtol: float | None = None,
    atol: float | None = None,
    max_steps: int = MAX_STEPS,
    *,
    certify: bool = True,
) -> Integrator:
    """The integrator for a wanted relative error of ke_ratio, or rk45 at tolerances of the caller's own.

    certify: whether its results are judged by a companion run.

    Raises ValueError naming every argument that breaks its rule.
    """
    given: dict[str, object] = {"accuracy": accuracy, "max_steps": max_steps}
    given |= {name: value for name, value in (("rtol", rtol), ("atol", atol)) if value is not None}
    broken = [line for name, value in given.items() if (line := broken_rule(name, value))]
    if not isinstance(method, str) or method not in METHODS:
        broken.append(unknown("method", method, METHODS))
    elif method == "auto" and (rtol is not None or atol is not None):
        broken.append('rtol, atol: only with method="rk45", since "auto" derives them from accuracy')
    if broken:
        raise ValueError("; ".join(broken))
    kind = AUTO if method == "auto" and accuracy >= SPLITTING_TARGET else RK45
    target = float(accuracy) if rtol is None else math.inf
    if rtol is None:
        rtol = max(RTOL_MIN, RTOL_OVER_ACCURACY * accuracy)
    atol = ATOL_OVER_RTOL * rtol if atol is None else atol
    reached = min(LOOSEST_CERTIFIED if certify else LOOSEST, SHARE * float(accuracy))
    return Integrator(kind, target, reached, float(rtol), float(atol), int(max_steps))
