"""Axes of a map count cells; this puts round numbers beside them.

A cell is as wide as any other, whatever the list of values: a zero has its own row below the smallest
positive value, uneven lists stay readable, and on the usual logarithmic grids the axis is logarithmic.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_LABEL_EACH = 8  # up to so many cells each carries its value
_CROWDED = 0.06  # labels nearer than this share of the axis run into each other


@dataclass(frozen=True)
class Ticks:
    """Positions in cells (0 is the centre of the first) with labels, and unlabelled positions between."""

    positions: list[float]
    labels: list[str]
    minor: list[float]


def ticks(values: NDArray[np.float64]) -> Ticks:
    """Ticks for an axis whose cells stand for `values` (ascending)."""
    if len(values) <= _LABEL_EACH:
        return Ticks([float(i) for i in range(len(values))], [label(value) for value in values], [])
    zero = 1 if values[0] == 0 else 0
    tries = ((_logarithmic(values[zero:]), range(1, 10)), (_linear(values[zero:]), ()))
    for rounds, factors in tries:
        found = _placed(rounds, values, zero, _multiples(values[zero:], factors))
        if len(found.labels) >= 3 + zero and np.diff(found.positions).min() >= _CROWDED * len(values):
            return found
    some = np.unique(np.linspace(0, len(values) - 1, 6).round().astype(int))
    return Ticks([float(i) for i in some], [label(values[i]) for i in some], [])


def label(value: float) -> str:
    """A number as it stands in a picture: 200, 0.01, or with a power of ten in mathtext."""
    if value == 0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    mantissa, exponent = f"{value:.2e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".")
    power = f"10^{{{int(exponent)}}}"
    return f"${power}$" if mantissa == "1" else rf"${mantissa}{{\times}}{power}$"


def _placed(rounds: Sequence[float], values: NDArray[np.float64], zero: int, minor: Sequence[float]) -> Ticks:
    """The round numbers at their places, after a zero only those that leave its label room."""
    pairs = [(_place(number, values, zero), label(number)) for number in rounds]
    if zero:
        pairs = [(0.0, label(0.0))] + [pair for pair in pairs if pair[0] >= _CROWDED * len(values)]
    between = [_place(number, values, zero) for number in minor]
    return Ticks([place for place, _ in pairs], [text for _, text in pairs], between)


def _place(number: float, values: NDArray[np.float64], zero: int) -> float:
    return zero + float(np.interp(number, values[zero:], np.arange(len(values) - zero)))


def _logarithmic(values: NDArray[np.float64]) -> list[float]:
    """Powers of ten in the range of the values; 1, 2, 5 times these where the range is short."""
    decades = _multiples(values, (1,))
    return decades if len(decades) >= 4 else _multiples(values, (1, 2, 5))


def _multiples(values: NDArray[np.float64], factors: Sequence[int]) -> list[float]:
    if values[0] <= 0:  # no table of the contract has such values, but a picture of one should not fail
        return []
    low, high = values[0] * (1 - 1e-9), values[-1] * (1 + 1e-9)
    exponents = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    numbers = [float(f"{factor}e{exponent}") for exponent in exponents for factor in factors]
    return [number for number in numbers if low <= number <= high]


def _linear(values: NDArray[np.float64]) -> list[float]:
    """Multiples of 1, 2 or 5 times a power of ten, at most about six."""
    low, high = float(values[0]), float(values[-1])
    rough = (high - low) / 6
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [float(f"{count * step:.12g}") for count in range(first, last + 1)]
