"""What is wrong with a spec, in words: one line for every problem, with key, rule and value."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from kernel.hints import did_you_mean, shown, unknown
from kernel.problems import ProblemsError
from kernel.task import is_number_of_model

LINE_MAX = 300  # characters of one problem: a value may be a list of thousands


class SpecError(ProblemsError):
    """What is wrong with a spec."""


def problem_lines(error: Mapping[str, Any], keys: Mapping[str, Sequence[str]]) -> list[str]:
    """`key: rule, got value`, one or several; `error`: one of pydantic's, `keys`: of `_keys`."""
    found = error.get("ctx", {}).get("error") if error["type"] == "value_error" else None
    return [cut(line) for line in found.lines] if isinstance(found, SpecError) else [problem_line(error, keys)]


def line_of(message: str, text: str) -> str:
    """`, got '..'`: the line of the text that a message of tomllib's names; nothing where it names none."""
    found = re.search(r"\(at line (\d+), column \d+\)$", message)
    return f", got {shown(text.split(chr(10))[int(found[1]) - 1].strip())}" if found else ""


def cut(line: str) -> str:
    """A line of LINE_MAX characters at most."""
    return line if len(line) <= LINE_MAX else f"{line[:LINE_MAX]}..."


def problem_line(error: Mapping[str, Any], keys: Mapping[str, Sequence[str]]) -> str:
    """`key: rule, got value`, cut off at LINE_MAX characters; `error`: one of pydantic's, `keys`: of `_keys`."""
    return cut(_text(error, keys))


def _text(error: Mapping[str, Any], keys: Mapping[str, Sequence[str]]) -> str:
    place, got = [str(part) for part in error["loc"]], error["input"]
    key = ".".join(place)
    match error["type"]:
        case "missing":
            return f"{key}: is missing"
        case "model_type":
            return f"{key}: must be a section [{key}], got {got!r}"
        case "extra_forbidden":
            way = meant(place, keys)
            if isinstance(got, dict) and place[0] in ("grid", "points") and is_number_of_model(f"{place[-1]}."):
                way = f' (a number of the model is written in quotes, as "{_dotted(place[-1], got)}")'
            return f"{key}: is not a known key{way}, got {got!r}"
        case "literal_error":
            return unknown(key, got, re.findall(r"'([^']*)'", error["ctx"]["expected"]))
        case "value_error":
            return f"{key}: {error['ctx']['error']}" if key else str(error["ctx"]["error"])
    rule = re.sub(r"^\w+ should", "must", error["msg"]).removesuffix(" after validation, not 0")
    return f"{key}: {rule}, got {got!r}"


def _dotted(name: str, value: object) -> str:
    """spring.slopes.0 of { slopes = { 0 = .. } }, which it is where nobody quotes it."""
    while isinstance(value, dict) and value and not {"log", "linear"} & value.keys():
        key, value = next(iter(value.items()))
        name = f"{name}.{key}"
    return name


def meant(place: Sequence[str], keys: Mapping[str, Sequence[str]]) -> str:
    """Another key of the same section, or the section where this one belongs."""
    section, word = place[0] if len(place) > 1 else "", place[-1]
    if near := did_you_mean(word, keys.get(section, ())):
        return near
    home = next((name for name, known in keys.items() if word in known), None)
    if home == "" and word != "name":
        return "" if word == section else f" (it is a section of its own, [{word}])"
    return "" if home is None else f" (it belongs {f'into [{home}]' if home else 'before all sections'})"
