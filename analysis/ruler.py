"""The cells of a map along one axis: each lies at its value and reaches half-way to its neighbours.

The axis is logarithmic unless its values are evenly spaced, span little, or one of them is negative. There a zero has a
cell of its own, as wide as the others, beyond a gap below the smallest positive value.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RELATIVE_MATCH = 1e-9  # numbers that differ by less are one: a value typed from a list of the table's values is it
_EVEN_FACTOR = 1.5  # steps that differ by less than this factor count as even: whole numbers are rounded
_LOG_SPAN = 3.0  # an axis whose ends are farther apart than this factor is logarithmic
_SINGLE_WIDTH = 0.1  # half the cell of a single value, in its natural logarithm
_GAP_WIDTH = 0.35  # between the cell of zero and the others, in widths of a cell


@dataclass(frozen=True)
class Ruler:
    """The cells that stand for `values` (n,), distinct and ascending, and how the axis is scaled."""

    values: Array
    log: bool

    @property
    def gap(self) -> bool:
        """Whether a zero stands apart, with an empty strip behind it."""
        return self.log and self.values[0] == 0

    @cached_property
    def borders(self) -> Array:
        """The n + 1 borders of the cells, ascending; with a gap n + 2, and the empty strip is between 1 and 2."""
        if not self.log:
            return _half_way(self.values, 0.5)
        logs = _half_way(np.log(self.values[1:] if self.gap else self.values), _SINGLE_WIDTH)
        if self.gap:
            width = float(np.median(np.diff(logs)))
            logs = np.r_[logs[0] - (1 + _GAP_WIDTH) * width, logs[0] - _GAP_WIDTH * width, logs]
        return np.exp(logs)

    @cached_property
    def cells(self) -> Array:
        """Lower and upper border of each value's cell, (n, 2)."""
        pairs = np.column_stack([self.borders[:-1], self.borders[1:]])
        return np.delete(pairs, 1, axis=0) if self.gap else pairs

    def place(self, value: float) -> float:
        """Where a value stands on the axis: at itself, but for the zero apart."""
        return float(np.exp(np.log(self.borders[:2]).mean())) if self.gap and value == 0 else value

    def share(self, value: float) -> float:
        """How far along the axis a value stands, 0 to 1."""
        low, high, here = self.borders[0], self.borders[-1], self.place(value)
        if self.log:
            low, high, here = np.log([low, high, here])
        return float((here - low) / (high - low))

    def spread(self, cells: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
        """A matrix of cells with an empty (nan) row or column where the gap is."""
        return np.insert(cells, 1, np.nan, axis=axis) if self.gap else cells


def ruler(values: Array) -> Ruler:
    """The ruler of these values (n,), distinct and ascending."""
    if len(values) == 1 or values[0] < 0:  # no logarithm has a negative value
        return Ruler(values, bool(values[0] > 0))
    steps = np.diff(values)
    even = len(values) > 2 and steps.max() < _EVEN_FACTOR * steps.min()
    wide = values[0] == 0 or values[-1] >= _LOG_SPAN * values[0]
    return Ruler(values, bool(wide and not even))


def _half_way(centres: Array, alone: float) -> Array:
    if len(centres) == 1:
        return np.array([centres[0] - alone, centres[0] + alone])
    middles = (centres[1:] + centres[:-1]) / 2
    ends = 1.5 * centres[[0, -1]] - 0.5 * centres[[1, -2]]
    return np.concatenate([ends[:1], middles, ends[1:]])
