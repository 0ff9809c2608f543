"""The contact of impactor and chain: Hertz's (section 2), F = K d^(3/2), or another power (kernel.laws.any_power)."""

import math
from typing import Any, NamedTuple

from kernel.jit import jit
from kernel.laws.any_power import OVERLAP_FALL, TINY, AnyPower
from kernel.laws.units import K_T, LENGTH
from kernel.task import outside

C_IMP = 2e9  # N/m^1.5
HERTZ = 1.5  # the exponent of two spheres
# Duration of an impact, 2.943 (5 / (4 K lightness))^(2/5) V^(-1/5) (K. L. Johnson, Contact Mechanics, 1985,
# section 11.4): 2.943 times the largest overlap over V.
DURATION = 2.943
NEWTON_STEPS, IMPULSE_NEWTON_STEPS = 60, 40  # at most: a handful settle what no blow-up has spoilt
# Relative change of the overlap, and of its root, in Newton's method, whose next one would be the square of it.
OVERLAP_SETTLED, ROOT_SETTLED = 1e-7, 1e-10


class ThreeHalves(NamedTuple):
    """F = K d^(3/2) where the bodies overlap by d > 0, else 0."""

    K: float

    def push(self, d: float) -> float:
        return self.K * d * math.sqrt(d) if d > 0.0 else 0.0

    def energy_at(self, d: float) -> float:
        return 0.4 * self.K * d * d * math.sqrt(d) if d > 0.0 else 0.0

    def stiffness_at(self, d: float) -> float:
        return 1.5 * self.K * math.sqrt(d)

    def period(self, mass: float, energy: float) -> float:
        # The last factor is the largest overlap to the power -1/4.
        return math.sqrt(mass / (1.5 * self.K)) * (2.5 * energy / self.K + TINY) ** -0.1

    def duration(self, lightness: float, V: float) -> float:
        return DURATION * (1.25 / (self.K * lightness)) ** 0.4 * V**-0.2

    def after(self, d: float, change: float) -> float:
        return d * (1.0 + change / (1.5 * self.push(d)))

    def overlap(self, free: float, softness: float, guess: float) -> float:
        return overlap_of(self.K * softness, free, guess)

    def impulse(self, d: float, free: float, softness: float) -> tuple[float, float]:
        return impulse_of(self.K, d, free, softness)

    def at_unit_speed(self, V: float) -> "ThreeHalves":
        return ThreeHalves(self.K * math.sqrt(V))

    def of_cells(self, N: int) -> "ThreeHalves":
        return ThreeHalves(self.K * K_T / (K_T * N**1.5))

    def softened(self, by: float) -> "ThreeHalves":
        return ThreeHalves(self.K / by)


class Hertz(NamedTuple):
    """Impactor and chain push each other with F = stiffness (overlap / chain length)^exponent, in k_T L.

    The paper's contact (section 2) by default.

    Parameters
    ----------
    stiffness : float
        1 to 1e12; the paper's by default.
    exponent : float
        1 to 3; 1.5 is Hertz's of two spheres. Another one is compiled when it is first used.

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Model(contact=kernel.Hertz(stiffness=1e5)).contact.exponent
    1.5
    """

    stiffness: float = C_IMP * math.sqrt(LENGTH) / K_T
    exponent: float = HERTZ

    def compiled(self) -> Any:
        """As the law that the compiled code knows, in chain lengths."""
        return ThreeHalves(self.stiffness) if self.exponent == HERTZ else AnyPower(self.stiffness, self.exponent)

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        return outside(1.0, 1e12, stiffness=self.stiffness) + outside(1.0, 3.0, exponent=self.exponent)


@jit
def overlap_of(compliance: float, free: float, guess: float) -> float:
    """The x >= 0 with x + compliance x^1.5 = free, by Newton's method."""
    if free <= 0.0:
        return 0.0
    x = guess if 0.0 < guess < free else free
    for _ in range(NEWTON_STEPS):
        root = math.sqrt(x)
        change = (x + compliance * x * root - free) / (1.0 + 1.5 * compliance * root)
        x = x - change if change < x else OVERLAP_FALL * x
        if abs(change) < OVERLAP_SETTLED * x:
            break
    return x


@jit
def impulse_of(K: float, d0: float, free: float, softness: float) -> tuple[float, float]:
    """Overlap at a step's end and mean force, as kernel.laws.Contact.impulse: Newton's method in the overlap's root."""
    if d0 <= 0.0 and free <= 0.0:
        return free, 0.0
    c, root = 0.4 * K * softness, math.sqrt(max(d0, 0.0))
    if d0 > 0.0 and c * root * root * root >= free:
        return _leave(root, free, c, softness)
    top = math.sqrt(free)
    b = root if d0 > 0.0 else top
    for _ in range(IMPULSE_NEWTON_STEPS):
        f, slope = _stay(root, b, free, c) if d0 > 0.0 else _arrive(-d0, b, free, c)
        new = b - f / slope
        if new <= 0.0:  # not min and max, which would hide a nan
            new = 0.5 * b
        if new > top:
            new = top
        done = abs(new - b) <= ROOT_SETTLED * new
        b = new
        if done:
            break
    return b * b, (free - b * b) / softness


@jit
def _leave(root: float, free: float, c: float, softness: float) -> tuple[float, float]:
    """The contact opens: E(d1) = 0 leaves a quadratic for d1 <= 0, solved without cancellation."""
    p, r = 0.5 * (root * root + free), root * root * (c * root * root * root - free)
    d1 = -r / (p + math.sqrt(p * p + r)) if p > 0.0 else p - math.sqrt(p * p + r)
    return d1, (free - d1) / softness


@jit
def _arrive(gap: float, b: float, free: float, c: float) -> tuple[float, float]:
    """d1 - free + softness F and its derivative, in b = sqrt(d1), from a gap: E(d0) = 0."""
    share, b4 = b * b + gap, b * b * b * b
    return b * b - free + c * b * b4 / share, 2.0 * b + c * (5.0 * b4 - 2.0 * b * b * b4 / share) / share


@jit
def _stay(a: float, b: float, free: float, c: float) -> tuple[float, float]:
    """The same from an overlap a^2: (b^5 - a^5) / (b^2 - a^2) with the common factor b - a taken out."""
    share = a + b
    quartic = a * a * a * a + b * (a * a * a + b * (a * a + b * (a + b)))
    slope = a * a * a + b * (2.0 * a * a + b * (3.0 * a + 4.0 * b))
    return b * b - free + c * quartic / share, 2.0 * b + c * (slope - quartic / share) / share
