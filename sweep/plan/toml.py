"""A spec given as a dict, as the text that a file of it would hold: what a run reads and its table keeps."""

import json
import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

from kernel.hints import shown


def as_toml(spec: Mapping[str, Any]) -> tuple[str, list[str]]:
    """The mapping as TOML, sections last, and a line for every value that TOML has no word for: in its place is ""."""
    problems = list[str]()
    plain = {key: value for key, value in spec.items() if not isinstance(value, Mapping)}
    sections = {key: value for key, value in spec.items() if isinstance(value, Mapping)}
    lines = _lines(plain, "", problems)
    for name, section in sections.items():
        lines += [f"[{_key(name, '', problems)}]", *_lines(section, f"{name}.", problems)]
    return "\n".join(lines) + "\n", problems


def _lines(section: Mapping[str, Any], place: str, problems: list[str]) -> list[str]:
    return [
        f"{_key(key, place, problems)} = {_value(value, f'{place}{key}', problems)}" for key, value in section.items()
    ]


def _key(key: object, place: str, problems: list[str]) -> str:
    text = str(key)
    plain = text.isascii() and text.replace("_", "").replace("-", "").isalnum()
    return text if plain else _text(text, f"{place}{_whole(text)}", problems)


def _text(text: str, place: str, problems: list[str]) -> str:
    whole = _whole(text)
    if whole != text:
        problems.append(f"{place}: must be a text without half a letter (a surrogate), got {shown(text)}")
    return json.dumps(whole, ensure_ascii=False).replace("\x7f", "\\u007f")  # TOML wants this one escaped too


def _whole(text: str) -> str:
    """The text with a question mark for each half of a letter, which no file can hold."""
    return text.encode(errors="replace").decode()


def _value(value: Any, place: str, problems: list[str]) -> str:
    if hasattr(value, "tolist"):  # numpy's numbers and arrays, pandas' columns
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | os.PathLike):
        return _text(os.fsdecode(value), place, problems)
    if isinstance(value, int):
        return json.dumps(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_lines(value, f"{place}.", problems)) + " }"
    if isinstance(value, Iterable):
        return "[" + ", ".join(_value(one, place, problems) for one in value) + "]"
    problems.append(f"{place}: must be a number, a text, a list or a mapping of these, got {shown(value)}")
    return '""'
