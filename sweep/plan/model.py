"""The chain of a sweep: a spec's section [model], and the axes of the grid that are numbers of it."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kernel.hints import meant_or_known
from kernel.problems import lines_of
from kernel.task import is_number_of_model
from sweep.errors import some_of
from sweep.plan.axis import axis_values
from sweep.plan.problems import SpecError

if TYPE_CHECKING:
    from kernel.lattice import Model
    from sweep.plan.points import Points

VARIED = "varied"  # stands in a list for a number that is an axis
COMBINATIONS_MAX = 10_000  # of the model's axes that are checked together; of more, each number's values are


def split_axes(section: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The keys of a section without those that are numbers of the model, and those."""
    axes = {key: value for key, value in section.items() if is_number_of_model(key)}
    return {key: value for key, value in section.items() if key not in axes}, axes


def values_of(axes: Mapping[str, Any]) -> dict[str, tuple[float, ...]]:
    """The values of every axis, which must be numbers; their rules are the model's."""
    found, problems = sound_values(axes)
    if problems:
        raise SpecError(problems)
    return found


def sound_values(axes: Mapping[str, Any]) -> tuple[dict[str, tuple[float, ...]], list[str]]:
    """The values of the axes that have some, and what is wrong with the others."""
    found, problems = dict[str, tuple[float, ...]](), list[str]()
    for name, value in axes.items():
        try:
            found[name] = axis_values(name, value)
        except ValueError as error:
            problems.append(f"grid.{name}: {error}")
    return found, problems


def model_of(given: Mapping[str, Any] | None) -> "Model":
    """The model of a section [model]; SpecError naming everything that is wrong."""
    from kernel.lattice import model_of as made  # and with it numba, which most plans do without

    try:
        return made(given or {})
    except ValueError as error:
        raise SpecError([f"model.{line}" for line in lines_of(error)]) from None


def is_papers(model: "Model") -> bool:
    """Whether it is the paper's chain: then all is as without a section [model]. Laws of other names may be equal."""
    return model.settings() == type(model)().settings()


def check_axes(
    given: Mapping[str, Any],
    varied: Sequence[str],
    together: Iterable[Mapping[str, float]],
    section: str,
    N: Sequence[int],
) -> "Model":
    """The model of a section [model] with the first numbers that stand together.

    SpecError where the model has no such number, where such numbers break a rule, or a list of it is not for these N.
    """
    from kernel.lattice import check_comparable

    model, first = model_of(given), None
    problems = _unfit(model, varied, section, N)
    broken = dict[str, str]()  # each once, with the first numbers at which it shows
    for numbers in together if {*varied} <= {*model.numbers()} else ():
        try:
            made = model.with_numbers(numbers)
            first = first or made
            check_comparable(made)
        except ValueError as error:
            said = ", ".join(f"{name} = {value:g}" for name, value in numbers.items())
            for line in lines_of(error):
                broken.setdefault(line.removeprefix("model: "), f" (at {said})" if said else "")
    where = section if varied else "model"
    problems += some_of([f"{where}: {line}{said}" for line, said in broken.items()], f"{where}: and {{}} more problems")
    if problems:
        raise SpecError(problems)
    return first or model


def _unfit(model: "Model", varied: Sequence[str], section: str, N: Sequence[int]) -> list[str]:
    """Numbers that the model does not have, and chains for which its lists are too long or too short."""
    from kernel.along import FORMS, KINDS

    known, problems = model.numbers(), list[str]()
    if model.sites is not None and (others := sorted({n for n in N if n != model.sites})):
        told = f"holds lists of {model.sites} numbers, so that {section}.N must be {model.sites}"
        problems.append(f"model: {told}, got {', '.join(some_of(map(str, others)))}")
    for name in [name for name in varied if name not in known]:
        part, _, inner = name.partition(".")
        form = next((f"{{ {', '.join(form._fields)} }}" for form in FORMS if inner in form._fields), "")
        way = f" (model.{part} must be {form})" if part in KINDS and form else meant_or_known(name, known)
        problems.append(f"{section}.{name}: the model has no such number{way}")
    return problems


def combinations(axes: Mapping[str, Sequence[float]]) -> Iterable[dict[str, float]]:
    """What a grid has of its axes; of more than COMBINATIONS_MAX every value once, beside the others' first ones."""
    if math.prod(map(len, axes.values())) <= COMBINATIONS_MAX:
        return (dict(zip(axes, values, strict=True)) for values in product(*axes.values()))
    first = {name: values[0] for name, values in axes.items()}
    return (first | {name: value} for name, values in axes.items() for value in values)


def occurring(points: "Points", ranges: Mapping[str, Any], varied: Sequence[str]) -> list[dict[str, float]]:
    """What points have of the varied numbers, COMBINATIONS_MAX at most, and both ends of each number's range."""
    if not varied:
        return [{}]
    each = np.unique(np.stack([points[name] for name in varied], axis=1), axis=0)
    if len(each) > COMBINATIONS_MAX:
        each = each[np.unique(np.concatenate([_spread_over(column, len(varied)) for column in each.T]))]
    found = [dict(zip(varied, numbers, strict=True)) for numbers in each.tolist()]
    ends = {name: next(iter(ranges[name].values())) for name in varied if isinstance(ranges.get(name), Mapping)}
    return found + [found[0] | {name: float(end)} for name, both in ends.items() for end in both]


def _spread_over(column: NDArray[np.float64], shares: int) -> NDArray[np.int64]:
    """Where each value stands first; of more than a share of COMBINATIONS_MAX some, the least and the largest too.

    Most rules are ranges, which these two break if any does; and what stands together in no point breaks no rule.
    """
    first = np.unique(column, return_index=True)[1]
    few = min(len(first), COMBINATIONS_MAX // shares)
    return np.asarray(first[np.linspace(0, len(first) - 1, few).astype(np.int64)])


def settings_of(model: "Model", axes: Sequence[str]) -> dict[str, Any]:
    """What a table says of its model: every number but those that are axes, which its rows hold.

    One in a list is VARIED, as the list would lose its length.
    """
    settings = model.settings()
    for name in axes:
        *parts, number = name.split(".")
        place: Any = settings
        for part in parts:
            place = place[part]
        if isinstance(place, list):
            place[int(number)] = VARIED
        else:
            del place[number]
    return settings
