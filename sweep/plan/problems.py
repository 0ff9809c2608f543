"""What is wrong with a spec, in words: one line for each of pydantic's errors."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from kernel.hints import did_you_mean, unknown

LINE_MAX = 300  # characters of one problem: a value may be a list of thousands


def line(error: Mapping[str, Any], keys: Mapping[str, Sequence[str]]) -> str:
    """`key: rule, got value`, at most LINE_MAX characters and three dots.

    Parameters
    ----------
    error : one of pydantic's ValidationError.errors().
    keys : of every section of a spec those that it may have; the top's under "".
    """
    told = _told(error, keys)
    return told if len(told) <= LINE_MAX else f"{told[:LINE_MAX]}..."


def _told(error: Mapping[str, Any], keys: Mapping[str, Sequence[str]]) -> str:
    place, got = [str(part) for part in error["loc"]], error["input"]
    key = ".".join(place)
    match error["type"]:
        case "missing":
            return f"{key}: is missing"
        case "model_type":
            return f"{key}: must be a section [{key}], got {got!r}"
        case "extra_forbidden":
            return f"{key}: is not a known key{_meant(place, keys)}, got {got!r}"
        case "literal_error":
            return unknown(key, got, re.findall(r"'([^']*)'", error["ctx"]["expected"]))
        case "value_error":
            return f"{key}: {error['ctx']['error']}" if key else str(error["ctx"]["error"])
    rule = re.sub(r"^\w+ should", "must", error["msg"]).removesuffix(" after validation, not 0")
    return f"{key}: {rule}, got {got!r}"


def _meant(place: Sequence[str], keys: Mapping[str, Sequence[str]]) -> str:
    """Another key of the same section, or the section where this one belongs."""
    section, word = place[0] if len(place) > 1 else "", place[-1]
    if near := did_you_mean(word, keys.get(section, ())):
        return near
    home = next((name for name, known in keys.items() if word in known), None)
    return "" if home is None else f" (it belongs {f'into [{home}]' if home else 'before all sections'})"
