"""A scene: a chain, what happens to it, and what to observe. Nothing that is not observed is computed or stored."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from kernel.model import T_END_OVER_N, V0, Chain, make_chain
from kernel.observers import OBSERVERS, Observer
from kernel.task import broken_rule

LAWS = ("bistable", "linear")


@dataclass(frozen=True)
class Impact:
    """A rigid mass strikes site 1; the run lasts 2.25 N (paper section 2)."""

    M_over_M0: float  # impactor mass over nominal
    V_over_V0: float  # impact speed over nominal

    def problems(self) -> list[str]:
        """Every broken rule."""
        return [line for name, value in vars(self).items() if (line := broken_rule(name, value))]


@dataclass(frozen=True)
class Drive:
    """The struck end is pushed at constant speed, as by an impactor of infinite mass (paper appendix A)."""

    speed: float  # in long-wave sound speeds; slow against 1 to be quasi-static
    strain: float = 0.8  # of the whole chain, at the end of the run

    def problems(self) -> list[str]:
        """Every broken rule."""
        return [line for name, value in vars(self).items() if (line := broken_rule(name, value))]


@dataclass(frozen=True)
class Scene:
    """What to simulate. ValueError where something breaks its rule, naming everything that does.

    `observe` is names, or names with options, for example {"ke_field": {"times": 400, "sites": 100}}.
    """

    N: int
    zeta_T: float
    event: Impact | Drive
    law: str = "bistable"
    observe: Iterable[str] | Mapping[str, Mapping[str, Any]] = ("peak_ke",)

    def __post_init__(self) -> None:
        if not isinstance(self.observe, Mapping):  # one name alone, or names that can be read only once
            names = (self.observe,) if isinstance(self.observe, str) else tuple(self.observe)
            object.__setattr__(self, "observe", names)
        given = {"N": self.N, "zeta_T": self.zeta_T}
        problems = [line for name, value in given.items() if (line := broken_rule(name, value))]
        if self.law not in LAWS:
            problems.append(f"law: must be one of {', '.join(LAWS)}, got {self.law!r}")
        problems += self.event.problems()
        if problems:
            raise ValueError("; ".join(problems))
        self.observers()

    def observers(self) -> dict[str, Observer]:
        """New observers, by name, for one run."""
        wanted = self.observe if isinstance(self.observe, Mapping) else {name: {} for name in self.observe}
        made, problems = {}, []
        for name, options in wanted.items():
            if name not in OBSERVERS:
                problems.append(f"observe: must be among {', '.join(OBSERVERS)}, got {name!r}")
                continue
            try:
                made[name] = OBSERVERS[name](self, **options)
            except (TypeError, ValueError) as error:
                problems.append(f"observe: {name}: {error}")
        if not wanted:
            problems.append(f"observe: must name at least one of {', '.join(OBSERVERS)}, got {self.observe!r}")
        if problems:
            raise ValueError("; ".join(problems))
        return made

    @property
    def chain(self) -> Chain:
        """In the compiled code's units."""
        if isinstance(self.event, Impact):
            return make_chain(self.N, self.zeta_T, self.event.M_over_M0, bistable=self.law == "bistable")
        return make_chain(self.N, self.zeta_T, math.inf, bistable=self.law == "bistable")

    @property
    def speed(self) -> float:
        """Of impactor or driven end at the start, in long-wave sound speeds."""
        return self.event.V_over_V0 * V0 if isinstance(self.event, Impact) else self.event.speed

    @property
    def t_end(self) -> float:
        """Duration in cell transit times."""
        return self.N * (T_END_OVER_N if isinstance(self.event, Impact) else self.event.strain / self.event.speed)

    @property
    def TE(self) -> float:  # noqa: N802 (the model's name)
        """Initial total energy; infinite where the end is driven."""
        return 0.5 * self.chain.impactor_mass * self.speed**2
