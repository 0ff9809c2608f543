"""One axis of the grid: a number, a list, or a range, turned into distinct values that keep the task's rules."""

from collections import Counter
from collections.abc import Iterable
from typing import Any

from kernel.hints import did_you_mean, shown
from kernel.problems import ProblemsError
from kernel.task import broken_rule, is_finite, is_number_of_model
from sweep.errors import some_of

POINTS_MAX = 1_000_000  # values of one axis: more is a typing error
AXIS_FORMS = "must be a number, a list, or a range { log = [a, b], points = n } or { linear = [a, b], points = n }"


def axis_values(name: str, value: Any) -> tuple[float, ...]:
    """The values of axis `name`, in the order given; ValueError with every broken rule."""
    if isinstance(value, dict):
        values = _range_values(name, value)
    elif isinstance(value, list):
        values = value
    else:
        values = [value]
    if not values:
        raise ValueError(f"must hold at least one value, got {value!r}")
    problems = broken_rules(name, values)
    sound = [v for v in values if not _broken(name, v)] if problems else values
    if twice := [v for v, times in Counter(sound).items() if times > 1]:
        problems.append(f"must hold distinct values, got {', '.join(map(repr, twice))} more than once")
    if problems:
        raise ProblemsError(problems)
    return tuple(int(v) if name == "N" else float(v) + 0.0 for v in values)  # + 0.0: -0.0 would be another task


def broken_rules(name: str, values: Iterable[Any]) -> list[str]:
    """A line `rule, got value, value` for every rule of the axis that one of the values breaks."""
    breaking = dict[str, dict[str, None]]()
    for line in (line for value in values if (line := _broken(name, value))):
        rule, _, value = line.removeprefix(f"{name}: ").partition(", got ")
        breaking.setdefault(rule, {})[value] = None
    return [f"{rule}, got {', '.join(some_of(of))}" for rule, of in breaking.items()]


def _broken(name: str, value: Any) -> str | None:
    """The line of a value that breaks its rule; those of the model's numbers are its own (sweep.plan.model)."""
    if is_number_of_model(name):
        return None if is_finite(value) else f"must be a finite number, got {shown(value)}"
    return broken_rule(name, value)


def _range_values(name: str, value: dict[str, Any]) -> list[float]:
    spacing = [key for key in ("log", "linear") if key in value]
    if len(spacing) != 1 or set(value) != {spacing[0], "points"}:
        known = ("log", "linear", "points")
        hints = "".join(f"; {key}{hint}" for key in value if key not in known and (hint := did_you_mean(key, known)))
        raise ProblemsError([f"{AXIS_FORMS}, got {value!r}{hints}", *_broken_ends(name, value)])
    ends, points = value[spacing[0]], value["points"]
    _check_range(name, spacing[0], ends, points)
    values = [_between(spacing[0], ends[0], ends[1], k / max(1, points - 1)) for k in range(points)]
    return list(dict.fromkeys(round(x) for x in values)) if takes_whole(name) else values


def takes_whole(name: str) -> bool:
    """Whether an input of a task is a whole number: N, or the seed of a disorder. Ranges of it are rounded."""
    return name == "N" or name.endswith(".seed")


def _broken_ends(name: str, value: dict[str, Any]) -> list[str]:
    """What breaks the axis' rule among the ends, as they are taken, of a range that is wrong besides."""
    ends = (x for key in ("log", "linear") if isinstance(value.get(key), list) for x in value[key])
    return broken_rules(name, (round(x) if takes_whole(name) and is_finite(x) else x for x in ends))


def _between(spacing: str, a: float, b: float, x: float) -> float:
    """The value at a share x of the way from a to b."""
    return rounded(a ** (1 - x) * b**x if spacing == "log" else a * (1 - x) + b * x)


def rounded(value: float) -> float:
    """To 12 digits: the last bits of pow differ between machines, and all must get the same tasks."""
    return float(f"{value:.12g}")


def _check_range(name: str, spacing: str, ends: Any, points: Any) -> None:
    problems = []
    if not (isinstance(points, int) and not isinstance(points, bool) and 1 <= points <= POINTS_MAX):
        problems.append(f"points must be a whole number from 1 to {POINTS_MAX}, got {points!r}")
    numbers = isinstance(ends, list) and len(ends) == 2 and all(map(is_finite, ends))
    if not numbers:
        problems.append(f"{spacing} must be two finite numbers [a, b], got {ends!r}")
    elif spacing == "log" and not min(ends) > 0:
        problems.append(f"log needs both ends above 0, got {ends!r}")
    elif ends[0] == ends[1] and points != 1:
        problems.append(f"{spacing} needs two different ends, got {ends!r}")
    if problems and numbers:
        problems += _broken_ends(name, {spacing: ends})
    if problems:
        raise ProblemsError(problems)
