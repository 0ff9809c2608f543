"""Grains that touch: a force that is a power of their overlap, and none where they have lost it."""

import math
from typing import Any, NamedTuple

from kernel.elementary import bend_of_power, power
from kernel.simd import negative_part
from kernel.task import outside

# Strain over precompression below which a series of four terms tells the energy to 1e-10 of itself.
SLIGHT_STRAIN = 1e-3


class PowerLaw(NamedTuple):
    """Grains pressed together: tension d/n (1 - (1 - e/d)^n) as long as e < d, then d/n: the grains are apart.

    d is the precompression, n the exponent; the slope at rest is 1. Without precompression the tension is -(-e)^n, the
    slope at rest 0: no sound travels, and there is no linear chain to compare with. Spheres have n = 1.5 (V. F.
    Nesterenko, Dynamics of Heterogeneous Materials, 2001, chapter 1).

    Parameters
    ----------
    exponent : float
        n, 1 to 10; 1.5 is Hertz's.
    precompression : float
        d, the overlap at rest in unit-cell lengths: 1e-6 to 100; in a scene also 0.

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> law = kernel.PowerLaw(1.5, 0.01)
    >>> law.stiffness_at(0.0), round(law.stiffness_at(-0.03), 12)
    (1.0, 2.0)
    """

    exponent: float = 1.5
    precompression: float = 0.01

    def excess(self, e: Any) -> Any:
        n, d = self.exponent, self.precompression
        if d == 0.0:
            return -1.0 * power(-1.0 * negative_part(e), n) - e
        return bend_of_power(e * (1.0 / d), n) * (-d / n)

    def energy_at(self, e: float) -> float:
        n, d = self.exponent, self.precompression
        if d == 0.0:
            return max(-e, 0.0) ** (n + 1.0) / (n + 1.0)
        if abs(e) < SLIGHT_STRAIN * d:  # where the difference below has no digits left
            x, m = e / d, n - 1.0
            return e * e * (0.5 - m * x / 6.0 * (1.0 - (m - 1.0) * x / 4.0 * (1.0 - (m - 2.0) * x / 5.0)))
        return d / n * (e - d / (n + 1.0) * (1.0 - max(1.0 - e / d, 0.0) ** (n + 1.0)))

    def stiffness_at(self, e: float) -> float:
        n, d = self.exponent, self.precompression
        y = -e if d == 0.0 else 1.0 - e / d
        if y <= 0.0:
            return 0.0
        return n * y ** (n - 1.0) if d == 0.0 else y ** (n - 1.0)

    def steepest(self, lowest: float, highest: float) -> float:
        return self.stiffness_at(lowest)

    def is_linear(self) -> bool:
        return False

    def stiffens_in_tension(self) -> bool:
        return False

    def stiffness_jumps(self) -> bool:
        return self.exponent == 1.0

    def barrier(self) -> float:
        return math.nan

    def has_sound(self) -> bool:
        """Whether it has a stiffness at rest, and with it a linear companion."""
        return self.precompression > 0.0

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        found = outside(1.0, 10.0, exponent=self.exponent)
        if self.precompression != 0.0:
            lines = outside(1e-6, 100.0, precompression=self.precompression)
            found += [line.replace(", got", ", in a scene also 0, got") for line in lines]
        return found
