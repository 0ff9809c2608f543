"""Toda's spring, whose chain is integrable: its solitons are known exactly."""

import math
from typing import Any, NamedTuple

from kernel.elementary import growth
from kernel.task import outside

SERIES_TO = 0.05  # of b e: below it e^-x - 1 + x would lose its digits


class Toda(NamedTuple):
    """Tension (1 - exp(-b e)) / b (M. Toda, J. Phys. Soc. Jpn. 22, 431, 1967).

    Parameters
    ----------
    b : float
        1e-3 to 100: the spring stiffens in compression as e^(b abs(e)).

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Toda(2.0).stiffness_at(0.0)
    1.0
    """

    b: float = 1.0

    def excess(self, e: Any) -> Any:
        return growth(e * -self.b) * (-1.0 / self.b) - e

    def energy_at(self, e: float) -> float:
        x = self.b * e
        if abs(x) < SERIES_TO:
            return (
                e * e * (0.5 - x * (1 / 6 - x * (1 / 24 - x * (1 / 120 - x * (1 / 720 - x * (1 / 5040 - x / 40320))))))
            )
        return (math.expm1(-x) + x) / (self.b * self.b)

    def stiffness_at(self, e: float) -> float:
        return math.exp(-self.b * e)

    def steepest(self, lowest: float, highest: float) -> float:
        return self.stiffness_at(lowest)

    def is_linear(self) -> bool:
        return False

    def stiffens_in_tension(self) -> bool:
        return False

    def stiffness_jumps(self) -> bool:
        return False

    def barrier(self) -> float:
        return math.nan

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        return outside(1e-3, 100.0, b=self.b)
