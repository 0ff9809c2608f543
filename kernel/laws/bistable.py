"""The paper's spring (section 2): linear in tension, a cubic with a barrier in compression."""

from typing import Any, NamedTuple

from kernel.laws.units import K_T, LENGTH
from kernel.simd import negative_part

C02 = 1187.0  # N/m^2, quadratic spring coefficient
C03 = 1524.0  # N/m^3, cubic spring coefficient
C2 = C02 * LENGTH / K_T
C3 = C03 * LENGTH**2 / K_T


class Bistable(NamedTuple):
    """Tension e + c2 e^2 + c3 e^3 for e < 0, e for e >= 0; both coefficients 0: a linear spring."""

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

    def companion(self) -> "Bistable":
        return Bistable(0.0, 0.0)
