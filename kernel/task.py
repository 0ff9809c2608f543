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


N_MAX = 1_000_000
POSITIVE = "must be a finite number above 0"

# name: (what a good value fulfils, how the rule reads to the user)
RULES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "N": (lambda x: _whole(x) and 2 <= x <= N_MAX, f"must be a whole number from 2 to {N_MAX}"),
    "zeta_T": (lambda x: _finite(x) and x >= 0, "must be a finite number of at least 0"),
    "M_over_M0": (lambda x: _finite(x) and x > 0, POSITIVE),
    "V_over_V0": (lambda x: _finite(x) and x > 0, POSITIVE),
    "speed": (lambda x: _finite(x) and x > 0, POSITIVE),
    "strain": (lambda x: _finite(x) and x > 0, POSITIVE),
    "accuracy": (lambda x: _finite(x) and 1e-8 <= x <= 1e-1, "must be a number from 1e-08 to 0.1"),
    "rtol": (lambda x: _finite(x) and 1e-13 <= x <= 1e-1, "must be a number from 1e-13 to 0.1"),
    "atol": (lambda x: _finite(x) and x > 0, POSITIVE),
    "max_steps": (lambda x: _whole(x) and x >= 1, "must be a whole number of at least 1"),
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
