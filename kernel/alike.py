"""Equality of what holds laws, forms or histories: as named tuples these compare equal whatever their kinds are."""

from dataclasses import fields
from typing import Any


class EqualInKind:
    """Base of a frozen dataclass with eq=False: equal where all fields are equal and of the same kinds."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, EqualInKind) and self._kinds_and_values() == other._kinds_and_values()

    def __hash__(self) -> int:
        return hash(self._kinds_and_values())

    def _kinds_and_values(self) -> tuple[Any, ...]:
        own: Any = self  # fields are a dataclass's
        values = [getattr(self, field.name) for field in fields(own)]
        return type(self), *map(type, values), *values
