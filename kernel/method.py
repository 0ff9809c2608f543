"""Which integrator, how tight: a value that the compiled code takes as it is."""

from typing import NamedTuple

from kernel.task import broken_rule

AUTO, RK45 = range(2)
METHODS = ("auto", "rk45")
MAX_STEPS = 200_000_000

# ode45's default AbsTol over its default RelTol; the absolute tolerance follows the relative one at this ratio.
ATOL_OVER_RTOL = 1e-3
# Measured on random tasks of the paper's domain: at this factor the reached error of ke_ratio is within the target
# in more than 95 of 100 well-conditioned tasks (at 1e-2 it just is, at target 1e-3).
RTOL_OVER_ACCURACY = 1e-3
RTOL_MIN = 1e-13


class Integrator(NamedTuple):
    """A method and how it is set. `choose` makes checked ones."""

    kind: int  # AUTO or RK45
    accuracy: float  # wanted relative error of ke_ratio
    rtol: float  # of rk45
    atol: float
    max_steps: int  # tried steps of one run, after which it ends with a status

    def looser(self, factor: float) -> "Integrator":
        """The same method with an error about `factor` times as large."""
        return Integrator(
            self.kind, self.accuracy * factor, min(0.1, self.rtol * factor), self.atol * factor, self.max_steps
        )

    def __str__(self) -> str:
        if self.kind == AUTO:
            return f"method auto, accuracy {self.accuracy:g}"
        return f"method rk45, rtol {self.rtol:g}, atol {self.atol:g}"


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
    if rtol is None:
        rtol = max(RTOL_MIN, RTOL_OVER_ACCURACY * accuracy)
    atol = ATOL_OVER_RTOL * rtol if atol is None else atol
    return Integrator(METHODS.index(method), float(accuracy), float(rtol), float(atol), int(max_steps))
