"""What of a table's chain is not as in the paper, in words for the small print of a picture."""

from collections.abc import Collection
from pathlib import Path
from typing import Any

from analysis.searched import spec_of
from kernel.lattice import FREE, Model
from kernel.task import MODEL_BOX


def chain_of(path: str | Path) -> str:
    """Sentences on the chain, without the numbers that the table varies; empty where it is the paper's, or not told."""
    spec = spec_of(path)
    model, paper = spec.get("model"), Model().settings()
    if not isinstance(model, dict):
        return ""
    varied = {*(spec.get("grid") or {}), *(spec.get("points") or {})}
    said = [_springs(model.get("spring"), varied)]
    if isinstance(contact := model.get("contact"), dict) and contact != paper["contact"]:
        said.append(_numbers("Contact: F = K w^p", contact, "contact", varied))
    said += [
        _along(name, value)
        for name, value in model.items()
        if name in MODEL_BOX and value != paper[name] and name not in varied
    ]
    if model.get("wall") == FREE:
        said.append("The far end is free.")
    return " ".join(filter(None, said))


def _springs(spring: Any, varied: Collection[str]) -> str:
    if not isinstance(spring, dict) or "law" not in spring:
        return ""
    return _numbers(f"Springs: {str(spring['law']).replace('_', ' ')}", spring, "spring", varied)


def _numbers(what: str, law: dict[str, Any], part: str, varied: Collection[str]) -> str:
    fixed = {name: value for name, value in law.items() if f"{part}.{name}" not in varied}
    return what + "".join(f", {name} = {x:.4g}" for name, x in fixed.items() if isinstance(x, int | float)) + "."


def _along(name: str, value: Any) -> str:
    """Of a number of the model, or of how it goes along the chain."""
    match value:
        case {"first": first, "last": last}:
            return f"{name.capitalize()} from {first:.4g} to {last:.4g} times the paper's along the chain."
        case {"spread": spread}:
            return f"{name.capitalize()} random, within {spread:.3g} of the mean."
        case [*numbers]:
            return f"{name.capitalize()} from a list of {len(numbers)} numbers."
    return {
        "site": f"The watched site is number {value:.4g} N.",
        "t_end": f"Runs end at t = {value:.4g} N.",
    }.get(name, f"{name.capitalize()} {value:.4g} times the paper's.")
