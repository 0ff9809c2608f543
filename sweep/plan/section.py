"""What every section of a spec is: its keys are known, its values cannot be changed.

Pydantic judges what keys must keep together only where each is sound by itself. So that all problems are told at once,
a section notes what is sound, and that is then judged as well as it can be.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from pydantic import BaseModel, ConfigDict, PrivateAttr, ValidationInfo, field_validator

from kernel.task import is_whole

if TYPE_CHECKING:
    from sweep.plan.points import Points


class Reading(NamedTuple):
    """The context in which a spec is read."""

    points: "Points | None"  # of its section [points]
    sound: dict[type["Section"], dict[str, Any]]  # of every section the values of keys that keep their own rules


def whole(value: object) -> object:
    """200 for 200.0, as which a spec may say 2e2; anything else as it is."""
    return int(value) if isinstance(value, float) and is_whole(value) else value


class Section(BaseModel):
    """A section."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    _unsound: Mapping[str, Any] = PrivateAttr({})  # keys that break a rule of their own, as given; see `sound_part`

    @field_validator("*")
    @classmethod
    def _noted(cls, value: Any, info: ValidationInfo) -> Any:
        if isinstance(info.context, Reading) and info.field_name is not None:
            info.context.sound.setdefault(cls, {})[info.field_name] = value
        return value

    @classmethod
    def sound_part(cls, given: Mapping[str, Any], reading: Reading) -> Self:
        """A section that was refused, with the keys that are sound; the others are as if left out, or None."""
        sound = reading.sound.get(cls, {})
        needed = {name: None for name, field in cls.model_fields.items() if field.is_required()}
        part = cls.model_construct(set(sound), **needed | sound)
        part._unsound = {name: given[name] for name in cls.model_fields if name in given and name not in sound}
        return part
