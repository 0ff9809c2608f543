"""The same cubic in compression and in tension: the chains of Fermi, Pasta, Ulam and Tsingou."""

import math
from typing import Any, NamedTuple

from kernel.task import outside


class Polynomial(NamedTuple):
    """Tension e + c2 e^2 + c3 e^3: FPUT's alpha chain with c3 = 0, their beta chain with c2 = 0.

    E. Fermi, J. Pasta, S. Ulam and M. Tsingou, Los Alamos report LA-1940, 1955.

    Parameters
    ----------
    c2 : float
        Quadratic coefficient, -1000 to 1000.
    c3 : float
        Cubic coefficient, 0 to 1000. With c3 = 0 a chain that gets too much energy breaks: its runs end as not finite,
        or by Dormand-Prince with too small a step.

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Polynomial(c2=0.25).stiffness_at(-0.1)
    0.95
    """

    c2: float = 0.0
    c3: float = 0.0

    def excess(self, e: Any) -> Any:
        return e * e * (self.c3 * e + self.c2)

    def energy_at(self, e: float) -> float:
        return e * e * (0.5 + e * (self.c2 / 3.0 + self.c3 / 4.0 * e))

    def stiffness_at(self, e: float) -> float:
        return 1.0 + e * (2.0 * self.c2 + 3.0 * self.c3 * e)

    def steepest(self, lowest: float, highest: float) -> float:
        # Convex: largest at one of its ends.
        return max(self.stiffness_at(lowest), self.stiffness_at(highest))

    def is_linear(self) -> bool:
        return self.c2 == 0.0 and self.c3 == 0.0

    def stiffens_in_tension(self) -> bool:
        return True

    def stiffness_jumps(self) -> bool:
        return False

    def barrier(self) -> float:
        # The zero of 1 + c2 e + c3 e^2 that is next to 0.
        square = self.c2 * self.c2 - 4.0 * self.c3
        return -2.0 / (self.c2 + math.copysign(math.sqrt(square), self.c2)) if square > 0.0 else math.nan

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        return outside(-1000.0, 1000.0, c2=self.c2) + outside(0.0, 1000.0, c3=self.c3)
