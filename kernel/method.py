"""Which integrator, how tight: a value that the compiled code takes as it is."""

from typing import NamedTuple

from kernel.task import broken_rule

AUTO, RK45 = range(2)
METHODS = ("auto", "rk45")
MAX_STEPS = 200_000_000

# ode45's default AbsTol over its default RelTol; the absolute tolerance follows the relative one at this ratio.
ATOL_OVER_RTOL = 1e-3
RTOL_MIN = 1e-13

# Measured on 240 reference tasks (tests/data/references.csv), so that 95 of 100 well-conditioned tasks reach their
# target: "auto" is set to this share of it, and never looser than SPLITTING_LOOSEST, beyond which nothing is saved.
SHARE, SPLITTING_LOOSEST = 0.3, 1e-3
# For targets below this "auto" is Dormand-Prince: the force's slope jumps, which caps the splitting's order.
SPLITTING_FINEST = 3e-6
RTOL_OVER_ACCURACY = 1e-3

# The companion run, from which the error is estimated, is this much looser.
COMPANION_ACCURACY, COMPANION_RTOL = 10 / 3, 32.0
# Where the two differ by more than this, inputs that differ by 1e-6 would too.
CHAOTIC, CHAOTIC_OVER_ACCURACY = 3e-3, 20.0


class Integrator(NamedTuple):
    """A method and how it is set. `choose` makes checked ones."""

    kind: int  # AUTO or RK45
    accuracy: float  # of "auto": relative error of the peak energy that the steps are chosen for
    rtol: float  # of rk45
    atol: float
    max_steps: int  # tried steps of one run, after which it ends with a status

    def companion(self) -> "Integrator":
        """The same method, looser: the difference of the two tells the error, and costs half to two thirds more."""
        rtol = min(0.1, self.rtol * COMPANION_RTOL)
        return Integrator(
            self.kind, self.accuracy * COMPANION_ACCURACY, rtol, self.atol * COMPANION_RTOL, self.max_steps
        )

    @property
    def least_error(self) -> float:
        """Two runs can agree by chance; the estimate is never below this."""
        return self.accuracy if self.kind == AUTO else 3.0 * self.rtol

    @property
    def chaotic_from(self) -> float:
        """The difference of the two runs from which a task counts as chaotic."""
        return max(CHAOTIC, CHAOTIC_OVER_ACCURACY * self.accuracy) if self.kind == AUTO else CHAOTIC

    def __str__(self) -> str:
        if self.kind == AUTO:
            return f"splitting at {self.accuracy:g}"
        return f"rk45 at rtol {self.rtol:g}, atol {self.atol:g}"


def choose(
    method: str = "auto",
    accuracy: float = 1e-3,
    rtol: float | None = None,
    atol: float | None = None,
    max_steps: int = MAX_STEPS,
) -> Integrator:
    """The integrator for a wanted relative error of ke_ratio, or rk45 at tolerances of the caller's own.

    Raises ValueError naming every argument that breaks its rule.
    """
    given = {"accuracy": accuracy, "rtol": rtol, "atol": atol, "max_steps": max_steps}
    broken = [line for name, value in given.items() if value is not None and (line := broken_rule(name, value))]
    if method not in METHODS:
        broken.append(f"method: must be one of {', '.join(METHODS)}, got {method!r}")
    elif method == "auto" and (rtol is not None or atol is not None):
        broken.append('rtol, atol: only with method="rk45", since "auto" derives them from accuracy')
    if broken:
        raise ValueError("; ".join(broken))
    kind = AUTO if method == "auto" and accuracy >= SPLITTING_FINEST else RK45
    if rtol is None:
        rtol = max(RTOL_MIN, RTOL_OVER_ACCURACY * accuracy)
    atol = ATOL_OVER_RTOL * rtol if atol is None else atol
    return Integrator(kind, min(SPLITTING_LOOSEST, SHARE * accuracy), float(rtol), float(atol), int(max_steps))
