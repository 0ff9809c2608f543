"""Scene files: which chains to look inside of, and what to observe there; one file per figure of the paper.

name = "paper figure 2"
[[scene]]                    # every combination of the lists is one scene
N = [50, 100]
law = ["linear", "bistable"]
zeta_T = 1e-4
M_over_M0 = 0.5              # or speed and strain: the end is driven, not struck
V_over_V0 = 4
observe = { ke_field = { times = 400, sites = 300 } }
"""

import tomllib
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationError, model_validator

import kernel
from sweep.errors import InputError
from sweep.plan.problems import problem_line
from sweep.plan.section import Section


def _listed(value: object) -> object:
    """A single value as a list of one."""
    return value if isinstance(value, list | tuple) else [value]


def _list_of(kind: Any) -> Any:
    return Annotated[list[kind], BeforeValidator(_listed), Field(min_length=1)]


class SceneSpec(Section):
    """Scenes that differ in the parameters given as lists; the first list varies slowest."""

    N: _list_of(int)  # type: ignore[valid-type]
    zeta_T: _list_of(float)  # type: ignore[valid-type]
    M_over_M0: _list_of(float) = ()  # type: ignore[valid-type]
    V_over_V0: _list_of(float) = ()  # type: ignore[valid-type]
    speed: float | None = None
    strain: float = 0.8
    law: _list_of(str) = ("bistable",)  # type: ignore[valid-type]
    observe: dict[str, dict[str, Any]]
    accuracy: Annotated[float, Field(ge=1e-8, le=1e-1)] = 1e-3

    @model_validator(mode="after")
    def _can_run(self) -> "SceneSpec":
        struck = bool(self.M_over_M0) and bool(self.V_over_V0)
        if struck == (self.speed is not None) or bool(self.M_over_M0) != bool(self.V_over_V0):
            raise ValueError("give either M_over_M0 and V_over_V0 (an impact) or speed (a driven end)")
        self.scenes()
        return self

    def scenes(self) -> list[kernel.Scene]:
        """The kernel's scenes; ValueError naming what breaks a rule."""
        events: list[kernel.Impact | kernel.Drive] = [
            kernel.Impact(*p) for p in product(self.M_over_M0, self.V_over_V0)
        ]
        if self.speed is not None:
            events = [kernel.Drive(self.speed, self.strain)]
        choices = product(self.law, self.zeta_T, events, self.N)
        return [kernel.Scene(N, zeta_T, event, law, self.observe) for law, zeta_T, event, N in choices]


class SceneFile(Section):
    """All scenes of one figure."""

    name: Annotated[str, Field(min_length=1)]
    scene: Annotated[list[SceneSpec], Field(min_length=1)]


KEYS = {"": tuple(SceneFile.model_fields), "scene": tuple(SceneSpec.model_fields)}  # by section of the file


@dataclass(frozen=True)
class Seen:
    """One scene and what was observed in it (arrays by observer and name, as in kernel.observers)."""

    scene: kernel.Scene
    observed: kernel.Simulation

    def __getitem__(self, observer: str) -> dict[str, Any]:
        return self.observed[observer]


def read_scenes(path: str | Path) -> SceneFile:
    """The validated file; InputError with one line per problem."""
    try:
        document = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        return SceneFile.model_validate(document)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValidationError as error:
        raise InputError(*dict.fromkeys(f"{path}: {problem_line(dict(one), KEYS)}" for one in error.errors())) from None
    except ValueError as error:  # not TOML, or not UTF-8
        raise InputError(f"{path}: is not TOML: {error}") from None


def simulate_all(file: SceneFile) -> list[Seen]:
    """Run every scene of the file; InputError where one does not reach its end."""
    seen = []
    for spec in file.scene:
        for scene in spec.scenes():
            result = kernel.simulate(scene, spec.accuracy)
            if result.status != "done":
                raise InputError(f"{file.name}: the scene with N = {scene.N}, {scene.law} ended early: {result.status}")
            seen.append(Seen(scene, result))
    return seen
