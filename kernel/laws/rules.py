"""What the numbers of a law must keep, in words."""

from typing import Any

from kernel.hints import shown
from kernel.task import is_finite


def outside(low: float, high: float, **values: Any) -> list[str]:
    """A line for every named value that is not a number from `low` to `high`."""
    rule = f"must be a number from {low:g} to {high:g}"
    return [
        f"{name}: {rule}, got {shown(value)}"
        for name, value in values.items()
        if not (is_finite(value) and low <= value <= high)
    ]


def not_a_list(low: float, high: float, **values: Any) -> list[str]:
    """A line for every named value that is no tuple of numbers from `low` to `high`."""
    rule = f"must be a list of numbers from {low:g} to {high:g}"
    return [
        f"{name}: {rule}, got {shown(value)}"
        for name, value in values.items()
        if not (isinstance(value, tuple | list) and value and all(is_finite(x) and low <= x <= high for x in value))
    ]
