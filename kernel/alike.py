"""Equality of what holds laws, forms, histories or arrays: named tuples compare equal whatever their kinds are."""

from dataclasses import fields
from typing import Any

import numpy as np


class EqualInKind:
    """Base of a frozen dataclass with eq=False: equal where all fields are equal and of the same kinds."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, EqualInKind) and self._kinds_and_values() == other._kinds_and_values()

    def __hash__(self) -> int:
        return hash(self._kinds_and_values())

    def _kinds_and_values(self) -> tuple[Any, ...]:
        own: Any = self  # fields are a dataclass's
        values = [getattr(self, field.name) for field in fields(own)]
        plain = [x.tobytes() if isinstance(x, np.ndarray) else x for x in values]
        return type(self), *map(type, values), *plain
