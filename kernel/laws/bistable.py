"""The paper's spring (section 2): linear in tension, a cubic with a barrier in compression."""

import math
from typing import Any, NamedTuple

from kernel.laws.units import K_T, LENGTH
from kernel.simd import negative_part
from kernel.task import outside

C02 = 1187.0  # N/m^2, quadratic spring coefficient
C03 = 1524.0  # N/m^3, cubic spring coefficient
C2 = C02 * LENGTH / K_T
C3 = C03 * LENGTH**2 / K_T


class Bistable(NamedTuple):
    """Tension e + c2 e^2 + c3 e^3 for e < 0, e for e >= 0; both coefficients 0: a linear spring.

    The paper's spring (section 2) by default.

    Parameters
    ----------
    c2 : float
        Quadratic coefficient, -1000 to 1000; where it is above 0 the spring softens as it is compressed.
    c3 : float
        Cubic coefficient, 0 to 1000, above 0 where c2 is. A second stable state needs c2^2 > 4 c3.

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> print(f"{kernel.Bistable(c2=4.0, c3=3.5).barrier():.4f}")
    -0.3694
    """

    c2: float = C2
    c3: float = C3

    def excess(self, e: Any) -> Any:
        m = negative_part(e)
        return m * m * (self.c3 * m + self.c2)

    def energy_at(self, e: float) -> float:
        m = negative_part(e)
        return 0.5 * e * e + m * m * m * (self.c2 / 3.0 + self.c3 / 4.0 * m)

    def stiffness_at(self, e: float) -> float:
        m = negative_part(e)
        return 1.0 + m * (2.0 * self.c2 + 3.0 * self.c3 * m)

    def steepest(self, lowest: float, highest: float) -> float:
        # Convex in compression: largest at one of its ends.
        return max(1.0, self.stiffness_at(lowest))

    def is_linear(self) -> bool:
        return self.c2 == 0.0 and self.c3 == 0.0

    def stiffens_in_tension(self) -> bool:
        return False

    def stiffness_jumps(self) -> bool:
        return False

    def barrier(self) -> float:
        # The first zero of 1 + c2 e + c3 e^2 below 0.
        square = self.c2 * self.c2 - 4.0 * self.c3
        return -2.0 / (self.c2 + math.sqrt(square)) if self.c2 > 0.0 and square > 0.0 else math.nan

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        found = outside(-1000.0, 1000.0, c2=self.c2) + outside(0.0, 1000.0, c3=self.c3)
        if not found and self.c2 > 0.0 and self.c3 == 0.0:
            found = [f"c3: must be above 0 where c2 is, or a link could collapse without end, got c2 = {self.c2:g}"]
        return found
