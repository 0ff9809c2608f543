"""The chain of a sweep: a spec's section [model], and the axes of the grid that are numbers of it."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice, product
from typing import TYPE_CHECKING, Any

from kernel.hints import did_you_mean
from kernel.problems import lines_of
from kernel.task import is_number_of_model
from sweep.plan.axis import PROBLEMS_MAX, axis_values
from sweep.plan.problems import SpecError

if TYPE_CHECKING:
    from kernel.lattice import Model

LAWS = ("spring", "contact")  # of a model: each has a default for every number
COMBINATIONS_MAX = 10_000  # of the model's axes that are checked together; of more, each value is checked alone


def split_axes(section: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The keys of a section without those that are numbers of the model, and those."""
    axes = {key: value for key, value in section.items() if is_number_of_model(key)}
    return {key: value for key, value in section.items() if key not in axes}, axes


def values_of(axes: Mapping[str, Any]) -> dict[str, tuple[float, ...]]:
    """The values of every axis, which must be numbers; their rules are the model's."""
    found, problems = dict[str, tuple[float, ...]](), list[str]()
    for name, value in axes.items():
        try:
            found[name] = axis_values(name, value)
        except ValueError as error:
            problems.append(f"grid.{name}: {error}")
    if problems:
        raise SpecError(problems)
    return found


def model_of(given: Mapping[str, Any] | None) -> "Model":
    """The model of a section [model]; SpecError naming everything that is wrong."""
    from kernel.lattice import model_of as made  # and with it numba, which most plans do without

    try:
        return made(given or {})
    except ValueError as error:
        raise SpecError([f"model.{line}" for line in lines_of(error)]) from None


def check_axes(
    model: "Model", varied: Sequence[str], together: Iterable[Mapping[str, float]], section: str, N: Sequence[int]
) -> "Model":
    """The model of the first numbers that stand together.

    SpecError where the model has no such number, where such numbers break a rule, or a list of it is not for these N.
    """
    from kernel.along import FORMS, KINDS
    from kernel.lattice import check_comparable

    known, problems, where, first = model.numbers(), list[str](), section if varied else "model", model
    if model.sites is not None and (others := sorted({n for n in N if n != model.sites})):
        told = f"holds lists of {model.sites} numbers, so that {section}.N must be {model.sites}"
        problems.append(f"model: {told}, got {', '.join(map(str, others[:PROBLEMS_MAX]))}")
    for name in varied:
        if name not in known:
            part, _, inner = name.partition(".")
            form = next((f"{{ {', '.join(form._fields)} }}" for form in FORMS if inner in form._fields), "")
            way = f" (model.{part} must be {form})" if part in KINDS and form else did_you_mean(name, known)
            problems.append(f"{section}.{name}: the model has no such number{way}")
    if problems:
        raise SpecError(problems)
    for k, numbers in enumerate(together):
        try:
            made = model.with_numbers(numbers)
            first = first if k else made
            check_comparable(made)
        except ValueError as error:
            said = ", ".join(f"{name} = {value:g}" for name, value in numbers.items())
            lines = [line.removeprefix("model: ") for line in lines_of(error)]
            problems += [f"{where}: {line}{f' (at {said})' if said else ''}" for line in lines]
    if problems:
        raise SpecError(list(islice(dict.fromkeys(problems), PROBLEMS_MAX)))
    return first


def combinations(axes: Mapping[str, Sequence[float]]) -> Iterator[dict[str, float]]:
    """What a grid has of its axes; of more than COMBINATIONS_MAX every value once, beside the others' first ones."""
    if math.prod(map(len, axes.values())) <= COMBINATIONS_MAX:
        return (dict(zip(axes, values, strict=True)) for values in product(*axes.values()))
    first = {name: values[0] for name, values in axes.items()}
    return (first | {name: value} for name, values in axes.items() for value in values)


def settings_of(model: "Model", axes: Sequence[str]) -> dict[str, Any]:
    """What a table says of its model: every number but those that are axes, which its rows hold.

    A number of a list stays, as the list would lose its length, and so do those that say how mass, stiffness or damping
    goes along the chain; then `model` has the first value.
    """
    settings = model.settings()
    for name in axes:
        part, _, number = name.partition(".")
        if not number:
            del settings[part]
        elif part in LAWS and number in settings[part]:
            del settings[part][number]
    return settings
