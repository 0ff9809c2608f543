"""What of a table's chain is not as in the paper, in words for the small print of a picture."""

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from analysis.checks import model_axes
from analysis.searched import spec_of
from kernel.task import MODEL_BOX


def chain_of(path: str | Path, table: pd.DataFrame) -> str:
    """Sentences on the chain, without the numbers that the table varies; empty where it is the paper's, or not told.

    table: its rows, all or some.
    """
    model, varied = spec_of(path).get("model"), model_axes(table)
    if not isinstance(model, dict):
        return ""
    from kernel.lattice import FREE, Model  # and with it the compiler, which tables of the paper's chain do without

    paper = Model().settings()
    said = [_springs(model.get("spring"), varied)]
    if isinstance(contact := model.get("contact"), dict) and contact != paper["contact"]:
        said.append(_numbers("Contact: F = K w^p", contact, "contact", varied))
    for name, value in model.items():
        if name in MODEL_BOX and value != paper[name] and name not in varied:
            said.append(_along(name, value, varied))
    if model.get("wall") == FREE:
        said.append("The far end is free.")
    return " ".join(filter(None, said))


def is_papers(path: str | Path, rows: pd.DataFrame) -> bool:
    """Whether a table tells that its chain is the paper's; a CSV does not tell."""
    return bool(spec_of(path)) and not chain_of(path, rows) and not model_axes(rows)


def made_of(path: str | Path, rows: pd.DataFrame) -> str:
    """Sentences on the chain, the paper's too, and on how accurate its rows are; empty where a table does not tell."""
    from sweep.plan.sections import Accuracy  # pydantic, which the pictures do without
    from sweep.store.reuse import in_words

    chain = "The paper's chain." if is_papers(path, rows) else chain_of(path, rows)
    try:
        accuracy = f"Computed by {in_words(Accuracy.model_validate(spec_of(path)['accuracy']))}."
    except (KeyError, ValueError):
        accuracy = ""
    return " ".join(filter(None, (chain, accuracy)))


def told_of(path: str | Path, rows: pd.DataFrame) -> str:
    """Both kinds of sentence, on rows that are shown together."""
    return " ".join(filter(None, (chain_of(path, rows), alike_in(rows))))


def alike_in(rows: pd.DataFrame) -> str:
    """A sentence on those numbers of the model that the table varies and these rows do not; empty without any."""
    alike = [f"{name} = {rows[name].iloc[0]:.4g}" for name in model_axes(rows) if len(rows[name].unique()) == 1]
    return f"All at {', '.join(alike)}." if alike else ""


def _springs(spring: Any, varied: Collection[str]) -> str:
    if not isinstance(spring, dict) or "law" not in spring:
        return ""
    return _numbers(f"Springs: {str(spring['law']).replace('_', ' ')}", spring, "spring", varied)


def _numbers(what: str, law: dict[str, Any], part: str, varied: Collection[str]) -> str:
    fixed = {name: x for name, x in _single(law) if f"{part}.{name}" not in varied}
    return what + "".join(f", {name} = {x:.4g}" for name, x in fixed.items()) + "."


def _single(law: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """The numbers of a law, those of a list by the names of their axes, as slopes.0."""
    for name, value in law.items():
        if isinstance(value, list | tuple):
            yield from ((f"{name}.{i}", x) for i, x in enumerate(value))
        elif isinstance(value, int | float):
            yield name, value


def _along(name: str, value: Any, varied: Collection[str]) -> str:
    """Of a number of the model, or of how it goes along the chain; what of it the table varies is told by its name."""
    if name == "site":
        return f"The watched site is number {value:.4g} N, rounded up."
    if name == "t_end":
        return f"Runs end at t = {value:.4g} N."
    match value:
        case {}:  # of its numbers, those that are axes may be missing
            how = _by_form(name, value, varied)
        case [*numbers]:
            how = f"from a list of {len(numbers)} numbers"
        case _:
            how = f"{value:.4g} times the paper's"
    return f"{name.capitalize()} {how}."


def _by_form(part: str, numbers: dict[str, Any], varied: Collection[str]) -> str:
    """Of the numbers of a form, as { first = 1, last = 2 }: how it goes along the chain."""

    def told(name: str) -> str:
        axis = f"{part}.{name}"
        return axis if axis in varied else f"{numbers[name]:.4g}"

    if "spread" in numbers or f"{part}.spread" in varied:
        return f"random, within {told('spread')} of the mean"
    return f"from {told('first')} to {told('last')} times the paper's along the chain"
