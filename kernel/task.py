"""The parameters of one task, and the rules that they must keep."""

import math
import numbers
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.hints import shown
from kernel.problems import ProblemsError, lines_of, tried


def is_whole(value: Any) -> bool:
    """Whether it is a whole number, of whatever type: 200.0 is 200, True is none."""
    return is_finite(value) and value == int(value)


def is_finite(value: Any) -> bool:
    """Whether it is a real number that a float can hold; True is none."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return False
    try:
        return math.isfinite(value)
    except (OverflowError, TypeError):  # a whole number beyond every float, or numpy's difference of dates
        return False


def is_disguised(given: Any) -> bool:
    """Whether numpy would take for numbers what is none: True or False among them, or an entry that is masked."""
    if hasattr(given, "dtype"):
        return getattr(given.dtype, "kind", "") == "b" or bool(np.ma.is_masked(given))
    if isinstance(given, Sequence) and not isinstance(given, str):
        return any(map(is_disguised, given))
    return isinstance(given, bool)


def finite_numbers(given: Any) -> NDArray[np.float64] | None:
    """A new array (n,) of what somebody gave as finite numbers; None where they are none, as text and True."""
    if is_disguised(given):
        return None
    try:
        values = np.array(given, np.float64)
    except (TypeError, ValueError, OverflowError):  # words, lists of different lengths, or beyond every float
        return None
    plain = isinstance(given, np.ndarray) and given.dtype.kind in "iuf"
    if values.ndim != 1 or not len(values) or not (plain or all(map(is_finite, given))):
        return None
    return values if np.all(np.isfinite(values)) else None


# The box within which every method has been tried, corners and all (tests/extremes.py).
BOX: dict[str, tuple[float, float]] = {
    "N": (2, 10_000),
    "zeta_T": (0.0, 10.0),
    "M_over_M0": (0.01, 100.0),
    "V_over_V0": (0.01, 20.0),
}
PARAMETERS = tuple(BOX)
M0 = 0.159  # nominal impactor mass over total chain mass (the paper's rounded value)
V0 = 0.26  # nominal impact speed over the long-wave sound speed
T_END_OVER_N = 2.25  # how long the paper's run is, in times that sound takes to cross the chain
# The ranges of the model's own numbers; those of its laws stand with the laws (kernel.laws).
MODEL_BOX: dict[str, tuple[float, float]] = {
    "t_end": (0.01, 1000.0),
    "site": (1e-4, 1.0),
    "mass": (1e-3, 1e3),
    "stiffness": (1e-3, 1e3),
    "damping": (0.0, 1e3),
}
RTOL_MIN, RTOL_MAX = 1e-13, 0.1
WORKERS_MAX = 1024  # threads: more cores than any machine has
Rule = tuple[Callable[[Any], bool], str]  # what a good value fulfils, how the rule reads to the user


def _number(low: float, high: float) -> Rule:
    return lambda x: is_finite(x) and low <= x <= high, f"must be a number from {low:g} to {high:g}"


def list_of(low: float, high: float) -> Rule:
    """Of a tuple of numbers in this range."""
    holds, words = _number(low, high)
    good = lambda x: isinstance(x, tuple | list) and bool(x) and all(map(holds, x))  # noqa: E731
    return good, words.replace("a number", "a list of numbers")


def _whole_number(low: float, high: float, highest: str) -> Rule:
    return lambda x: is_whole(x) and low <= x <= high, f"must be a whole number from {low:g} to {highest}"


ABOVE_0: Rule = (lambda x: is_finite(x) and x > 0, "must be a finite number above 0")
NOT_0: Rule = (lambda x: is_finite(x) and x != 0, "must be a finite number other than 0")
SEED = _whole_number(0, 2**32 - 1, highest="2**32 - 1")
FLAG: Rule = (lambda x: isinstance(x, bool | np.bool_), "must be True or False")
RULES: dict[str, Rule] = {
    "N": _whole_number(*BOX["N"], highest=f"{BOX['N'][1]:g}"),
    "zeta_T": _number(*BOX["zeta_T"]),
    "M_over_M0": _number(*BOX["M_over_M0"]),
    "V_over_V0": _number(*BOX["V_over_V0"]),
    "speed": ABOVE_0,
    "strain": ABOVE_0,
    "accuracy": _number(1e-8, 1e-1),
    "rtol": _number(RTOL_MIN, RTOL_MAX),
    "atol": ABOVE_0,
    "max_steps": _whole_number(1, 10**15, highest="10**15"),
    "workers": _whole_number(1, WORKERS_MAX, highest=f"{WORKERS_MAX}"),
    "certify": FLAG,
}


def is_number_of_model(name: str) -> bool:
    """Whether a column may be a number of a kernel.Model, as "spring.c2" or "site"."""
    return name in MODEL_BOX or name.startswith(("spring.", "contact.", "mass.", "stiffness.", "damping."))


def is_input(name: str) -> bool:
    """Whether a column says which task it is: a parameter, or a number of the model."""
    return name in BOX or is_number_of_model(name)


def breaking(rule: Rule, **values: object) -> list[str]:
    """A line `name: rule, got value` for every named value that breaks the rule."""
    holds, words = rule
    return [f"{name}: {words}, got {shown(value)}" for name, value in values.items() if not holds(value)]


def outside(low: float, high: float, **values: Any) -> list[str]:
    """A line for every named value that is not a number from `low` to `high`."""
    return breaking(_number(low, high), **values)


def broken_rule(name: str, value: object) -> str | None:
    """The line where `value` breaks the rule of `name`, else None."""
    return next(iter(breaking(RULES[name], **{name: value})), None)


def check(values: Mapping[str, object]) -> None:
    """Raise one ValueError that names every value that breaks its rule."""
    broken = [line for name, value in values.items() if (line := broken_rule(name, value))]
    if broken:
        raise ProblemsError(broken)


def gathered(*makers: Callable[[], Any]) -> list[Any]:
    """What the makers return; one ValueError with the problems of all of them that raise one."""
    made, problems = tried(makers, ValueError, lines_of)
    if problems:
        raise ProblemsError(problems)
    return made


@dataclass(frozen=True)
class Task:
    """One impact on one chain.

    Parameters
    ----------
    N : int
        Number of unit cells, 2 to 10 000; 200.0 is 200.
    zeta_T : float
        Bulk damping ratio, 0 to 10.
    M_over_M0 : float
        Impactor mass over the nominal one (0.159 of the chain's mass), 0.01 to 100.
    V_over_V0 : float
        Impact speed over the nominal one (0.26 long-wave sound speeds), 0.01 to 20.

    Raises
    ------
    ValueError
        Naming every parameter that breaks its rule, with the rule and the value.

    Examples
    --------
    >>> import kernel
    >>> kernel.Task(200.0, 4e-4, 2, 2)
    Task(N=200, zeta_T=0.0004, M_over_M0=2.0, V_over_V0=2.0)
    """

    N: int
    zeta_T: float
    M_over_M0: float
    V_over_V0: float

    def __post_init__(self) -> None:
        check(vars(self))
        for name in PARAMETERS:  # frozen: there is no other way
            object.__setattr__(self, name, (int if name == "N" else float)(getattr(self, name)))
