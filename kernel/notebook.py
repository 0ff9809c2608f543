"""Results as notebooks show them: a table of names and values."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from html import escape
from typing import Any


class ShownAsTable:
    """A dataclass whose fields a notebook lists. A list, frame or array stands there by its size."""

    def _repr_html_(self) -> str:
        shown: Any = self
        lines = [(field.name, words(getattr(shown, field.name))) for field in fields(shown)]
        cells = "".join(f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in lines)
        return f"<table>{cells}</table>"


def words(value: Any) -> str:
    """A value in a line."""
    if value is None:
        return "not known"
    if isinstance(value, float):
        return f"{value:.6g}"
    if is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, Mapping):
        return "; ".join(f"{name}: {words(one)}" for name, one in value.items())
    if (shape := getattr(value, "shape", ())) != ():
        return " x ".join(map(str, shape))
    if isinstance(value, tuple):
        return " to ".join(map(words, value))
    return str(value)
