"""A contact whose force is any power of the overlap."""

import math
from typing import NamedTuple

from kernel.jit import jit

NEWTON_STEPS = 80  # at most
OVERLAP_FALL = 0.01  # of an overlap: where a step of Newton's method would pass zero, this is tried next
TINY = 1e-300  # added to an energy that may be 0, where its overlap is divided by: no other energy is changed by it
SETTLED = 1e-12  # relative change of an overlap in a step of Newton's method, after which there is none
# Relative difference of two overlaps below which the mean force between them is taken from the middle.
CLOSE_OVERLAPS = 1e-4


class AnyPower(NamedTuple):
    """F = K d^p where the bodies overlap by d > 0, else 0."""

    K: float
    p: float

    def push(self, d: float) -> float:
        return self.K * d**self.p if d > 0.0 else 0.0

    def energy_at(self, d: float) -> float:
        return self.K * d ** (self.p + 1.0) / (self.p + 1.0) if d > 0.0 else 0.0

    def stiffness_at(self, d: float) -> float:
        return self.p * self.K * d ** (self.p - 1.0)

    def period(self, mass: float, energy: float) -> float:
        deepest = ((self.p + 1.0) * energy / self.K + TINY) ** (1.0 / (self.p + 1.0))
        return math.sqrt(mass / self.stiffness_at(deepest))

    def duration(self, lightness: float, V: float) -> float:
        # Twice the largest overlap over V, times the integral of (1 - x^(p+1))^(-1/2) from 0 to 1.
        q = 1.0 / (self.p + 1.0)
        deepest = ((self.p + 1.0) * V * V / (2.0 * self.K * lightness)) ** q
        return 2.0 * deepest / V * math.sqrt(math.pi) * math.gamma(1.0 + q) / math.gamma(0.5 + q)

    def after(self, d: float, change: float) -> float:
        return d * (1.0 + change / (self.p * self.push(d)))

    def overlap(self, free: float, softness: float, guess: float) -> float:
        return overlap_of_power(self.K * softness, self.p, free, guess)

    def impulse(self, d: float, free: float, softness: float) -> tuple[float, float]:
        return impulse_of_power(self.K, self.p, d, free, softness)

    def at_unit_speed(self, V: float) -> "AnyPower":
        return AnyPower(self.K * V ** (self.p - 1.0), self.p)

    def of_cells(self, N: int) -> "AnyPower":
        return AnyPower(self.K / N**self.p, self.p)

    def softened(self, by: float) -> "AnyPower":
        return AnyPower(self.K / by, self.p)


@jit
def overlap_of_power(compliance: float, p: float, free: float, guess: float) -> float:
    """The x >= 0 with x + compliance x^p = free: convex, so that Newton's method comes from above."""
    if free <= 0.0:
        return 0.0
    x = guess if 0.0 < guess < free else free
    for _ in range(NEWTON_STEPS):
        force = compliance * x**p
        change = (x + force - free) / (1.0 + p * force / x)
        x = x - change if change < x else OVERLAP_FALL * x
        if abs(change) < SETTLED * x:
            break
    return x


@jit
def _mean_force(K: float, p: float, a: float, b: float) -> float:
    """(E(b) - E(a)) / (b - a) of the energy E of the contact."""
    if a > 0.0 and b > 0.0 and abs(b - a) < CLOSE_OVERLAPS * a:
        middle, step = 0.5 * (a + b), (b - a) / (a + b)
        return K * middle**p * (1.0 + p * (p - 1.0) * step * step / 6.0)  # Taylor's series, the step being small
    if a <= 0.0 and b <= 0.0:
        return 0.0
    return K * (max(b, 0.0) ** (p + 1.0) - max(a, 0.0) ** (p + 1.0)) / ((p + 1.0) * (b - a))


@jit
def impulse_of_power(K: float, p: float, d0: float, free: float, softness: float) -> tuple[float, float]:
    """Overlap at a step's end and mean force, as kernel.laws.Contact.impulse: the secant method within a bracket."""
    if d0 <= 0.0 and free <= 0.0:
        return free, 0.0
    high = free  # the force is never negative
    low = free - softness * K * max(d0, max(free, 0.0)) ** p
    above = high + softness * _mean_force(K, p, d0, high) - free
    below = low + softness * _mean_force(K, p, d0, low) - free
    x, side = high, 0
    for _ in range(NEWTON_STEPS):
        if not above > below:
            break
        x = (low * above - high * below) / (above - below)
        value = x + softness * _mean_force(K, p, d0, x) - free
        if abs(value) <= SETTLED * (abs(x) + abs(free)):
            break
        if value > 0.0:  # the Illinois rule: an end that stays loses half its weight
            high, above = x, value
            below = 0.5 * below if side > 0 else below
            side = 1
        else:
            low, below = x, value
            above = 0.5 * above if side < 0 else above
            side = -1
    return x, (free - x) / softness
