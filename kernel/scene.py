"""A scene: a chain, what happens to it, and what to observe. Nothing that is not observed is computed or stored."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from kernel.hints import shown, unknown
from kernel.laws import PAPER, SPRINGS
from kernel.model import M0, T_END_OVER_N, V0, Chain, chain_of
from kernel.observers import Observer, made, names
from kernel.task import broken_rule, check

LINEAR = "linear"  # the law with which the paper's is compared
LAWS = (*SPRINGS, LINEAR)


@dataclass(frozen=True)
class Impact:
    """A rigid mass strikes site 1; the run lasts 2.25 N cell transit times (paper section 2).

    Parameters
    ----------
    M_over_M0 : float
        Impactor mass over the nominal one (0.159 of the chain's mass), 0.01 to 100.
    V_over_V0 : float
        Impact speed over the nominal one (0.26 long-wave sound speeds), 0.01 to 20.

    Raises
    ------
    ValueError
        Naming every parameter that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Impact(2, 2)
    Impact(M_over_M0=2.0, V_over_V0=2.0)
    """

    M_over_M0: float
    V_over_V0: float

    def __post_init__(self) -> None:
        _check_numbers(self)


@dataclass(frozen=True)
class Drive:
    """The struck end is pushed at constant speed, as by an impactor of infinite mass (paper appendix A).

    Parameters
    ----------
    speed : float
        In long-wave sound speeds, above 0; slow against 1 to be quasi-static.
    strain : float
        Of the whole chain at the end of the run, above 0.

    Raises
    ------
    ValueError
        Naming every parameter that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Drive(1e-3)
    Drive(speed=0.001, strain=0.8)
    """

    speed: float
    strain: float = 0.8

    def __post_init__(self) -> None:
        _check_numbers(self)


def _check_numbers(event: Impact | Drive) -> None:
    check(vars(event))
    for name, value in vars(event).items():
        object.__setattr__(event, name, float(value))  # frozen: there is no other way


@dataclass(frozen=True)
class Scene:
    """What to simulate.

    Parameters
    ----------
    N : int
        Number of unit cells, 2 to 10 000; 200.0 is 200.
    zeta_T : float
        Bulk damping ratio, 0 to 10.
    event : Impact or Drive
        What happens to the struck end.
    law : str
        Of the springs: "bistable" or "linear".
    observe : str, names, or mapping of names to options
        What to record, for example {"ke_field": {"times": 400, "sites": 100}}; names, options, shapes and units stand
        in `kernel.observers`.

    Raises
    ------
    ValueError
        Naming everything that breaks its rule, options of observers included.

    Examples
    --------
    >>> import kernel
    >>> kernel.Scene(20, 1e-3, kernel.Impact(2, 2), observe="energy").t_end
    45.0
    """

    N: int
    zeta_T: float
    event: Impact | Drive
    law: str = "bistable"
    observe: Iterable[str] | Mapping[str, Mapping[str, Any]] = ("peak_ke",)

    def __post_init__(self) -> None:
        if isinstance(self.observe, str):
            object.__setattr__(self, "observe", (self.observe,))
        elif isinstance(self.observe, Iterable) and not isinstance(self.observe, Mapping):  # may be read only once
            object.__setattr__(self, "observe", tuple(self.observe))
        given = {"N": self.N, "zeta_T": self.zeta_T}
        problems = [line for name, value in given.items() if (line := broken_rule(name, value))]
        event: Any = self.event
        if not isinstance(event, Impact | Drive):
            problems.append(f"event: must be an Impact or a Drive, got {shown(event)}")
        if not isinstance(self.law, str) or self.law not in LAWS:
            problems.append(unknown("law", self.law, LAWS))
        if not problems:
            object.__setattr__(self, "N", int(self.N))
            object.__setattr__(self, "zeta_T", float(self.zeta_T))
        problems += self._problems_of_observe(whole=not problems)
        if problems:
            raise ValueError("; ".join(problems))

    def _problems_of_observe(self, whole: bool) -> list[str]:
        """Names that are none; options, which depend on the rest, only where the rest is `whole`."""
        asked: Any = self.observe
        if not isinstance(asked, Iterable) or not list(asked):
            return [f"observe: must name at least one of {', '.join(names())}, got {shown(asked)}"]
        problems = [unknown("observe", name, names()) for name in asked if not _is_one(name)]
        if whole:
            for name, options in self._wanted().items():
                try:
                    made(name, self, options)
                except ValueError as error:
                    problems.append(f"observe: {name}: {error}")
        return problems

    def _wanted(self) -> dict[str, Any]:
        """The options of every observer that there is."""
        options = self.observe if isinstance(self.observe, Mapping) else {}
        return {name: options.get(name, {}) for name in self.observe if _is_one(name)}

    def observers(self) -> dict[str, Observer]:
        """New observers, by name, for one run."""
        return {name: made(name, self, options) for name, options in self._wanted().items()}

    @property
    def chain(self) -> Chain:
        """In the compiled code's units."""
        spring = PAPER.companion() if self.law == LINEAR else SPRINGS[self.law]()
        if isinstance(self.event, Impact):
            return chain_of(self.N, self.zeta_T, self.event.M_over_M0 * M0, spring)
        return chain_of(self.N, self.zeta_T, math.inf, spring)

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


def _is_one(name: object) -> bool:
    return isinstance(name, str) and name in names()
