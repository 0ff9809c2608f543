"""The parameters of one task, and the rules that they must keep."""

import math
import numbers
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


def _whole(value: Any) -> bool:
    return not isinstance(value, bool) and isinstance(value, numbers.Integral)


def _finite(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


POSITIVE = "must be a finite number above 0"
# The box within which every method has been tried, corners and all (tests/extremes.py).
BOX: dict[str, tuple[float, float]] = {
    "N": (2, 10_000),
    "zeta_T": (0.0, 10.0),
    "M_over_M0": (0.01, 100.0),
    "V_over_V0": (0.01, 20.0),
}


def _in_box(name: str) -> tuple[Callable[[Any], bool], str]:
    low, high = BOX[name]
    return lambda x: _finite(x) and low <= x <= high, f"must be a number from {low:g} to {high:g}"


# name: (what a good value fulfils, how the rule reads to the user)
RULES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "N": (lambda x: _whole(x) and 2 <= x <= 10_000, "must be a whole number from 2 to 10000"),
    "zeta_T": _in_box("zeta_T"),
    "M_over_M0": _in_box("M_over_M0"),
    "V_over_V0": _in_box("V_over_V0"),
    "speed": (lambda x: _finite(x) and x > 0, POSITIVE),
    "strain": (lambda x: _finite(x) and x > 0, POSITIVE),
    "accuracy": (lambda x: _finite(x) and 1e-8 <= x <= 1e-1, "must be a number from 1e-08 to 0.1"),
    "rtol": (lambda x: _finite(x) and 1e-13 <= x <= 1e-1, "must be a number from 1e-13 to 0.1"),
    "atol": (lambda x: _finite(x) and x > 0, POSITIVE),
    "max_steps": (lambda x: _whole(x) and 1 <= x <= 10**15, "must be a whole number from 1 to 10**15"),
}


def broken_rule(name: str, value: object) -> str | None:
    """`name: rule, got value` where `value` breaks the rule of `name`, else None."""
    holds, rule = RULES[name]
    return None if holds(value) else f"{name}: {rule}, got {value!r}"


def check(values: Mapping[str, object]) -> None:
    """Raise one ValueError that names every value that breaks its rule."""
    broken = [line for name, value in values.items() if (line := broken_rule(name, value))]
    if broken:
        raise ValueError("; ".join(broken))


@dataclass(frozen=True)
class Task:
    """One impact on one chain; ValueError where a parameter breaks its rule."""

    N: int  # number of unit cells
    zeta_T: float  # bulk damping ratio
    M_over_M0: float  # impactor mass over nominal
    V_over_V0: float  # impact speed over nominal

    def __post_init__(self) -> None:
        check(vars(self))
