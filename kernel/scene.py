"""A scene: a chain, what happens to it, and what to observe. Nothing that is not observed is computed or stored."""

import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kernel.alike import EqualInKind
from kernel.hints import shown, unknown
from kernel.histories import HISTORIES, as_history
from kernel.lattice import PAPER_MODEL, Model, check_comparable
from kernel.model import Chain, Lattice, frequency_of, lattice_chain, linear_chain
from kernel.observers import Observed, Observer, made, names, problems_of
from kernel.problems import ProblemsError, lines_of, tried
from kernel.task import FLAG, M0, V0, breaking, broken_rule, check, finite_numbers, is_finite, outside
from kernel.varied import MASS, REST, STIFFNESS, DriverMotion, along_chain

LINEAR_LAW = "linear"  # the chain with which the model's is compared
SCENE_LAWS = ("bistable", LINEAR_LAW)
# Of what a chain is released from: squares of either, and fourth powers of the largest, stay within a float.
LARGEST, LEAST = 1e6, 1e-100
QUASI_STATIC_STRAIN = 0.8  # of the whole chain: beyond the paper's second stable state


@dataclass(frozen=True)
class Impact:
    """A rigid mass strikes site 1; the run lasts 2.25 N cell transit times, or as the model says (paper section 2).

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
        check(vars(self))
        for name, value in vars(self).items():
            object.__setattr__(self, name, float(value))  # frozen: there is no other way


@dataclass(frozen=True, eq=False)
class Drive(EqualInKind):
    """The struck end is pushed by a driver that moves as it is told, as an impactor of infinite mass would.

    At constant speed it is the quasi-static test of the paper's appendix A.

    Parameters
    ----------
    speed : float, Ramp, HalfSine, Harmonic or Samples
        Its velocity: constant, in long-wave sound speeds, above 0 (slow against 1 to be quasi-static), or a history.
    strain : float, optional
        With a constant speed: of the whole chain at the end of the run, above 0; 0.8 by default. Strain over speed is
        how long the run lasts over N. With a history it lasts as long as the model says (`Model.t_end`).
    hold : bool
        Whether the first site itself moves as told, pulled as well as pushed; else the driver pushes it through the
        contact, and may part from it.

    Raises
    ------
    ValueError
        Naming every parameter that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Drive(1e-3)
    Drive(speed=0.001, strain=0.8, hold=False)
    """

    speed: Any
    strain: float | None = None
    hold: bool = False

    def __post_init__(self) -> None:
        problems = []
        if isinstance(self.speed, HISTORIES):
            object.__setattr__(self, "speed", as_history(self.speed))  # frozen: there is no other way
            problems += [f"speed.{line}" for line in self.speed.problems()]
            if self.strain is not None:
                problems.append(f"strain: only with a constant speed, got {shown(self.strain)}")
        else:
            strain = QUASI_STATIC_STRAIN if self.strain is None else self.strain
            given = {"speed": self.speed, "strain": strain}
            problems += [line for name, value in given.items() if (line := broken_rule(name, value))]
            if not problems:
                object.__setattr__(self, "speed", float(self.speed))
                object.__setattr__(self, "strain", float(strain))
                problems += outside(LEAST, 1 / LEAST, speed=self.speed, **{"strain / speed": self.strain / self.speed})
        if problems := problems + breaking(FLAG, hold=self.hold):
            raise ProblemsError(problems)

    def motion(self, N: int) -> DriverMotion | None:
        """As the compiled code takes it; None where an impactor of infinite mass does the same."""
        if isinstance(self.speed, float) and not self.hold:
            return None
        motion: DriverMotion = as_history(self.speed).motion(N, self.hold)
        return motion


@dataclass(frozen=True, eq=False)
class Release(EqualInKind):
    """The chain starts from given displacements and velocities; nothing strikes it, and its first site is free or held.

    Parameters
    ----------
    u : (N,) numbers
        Displacements of the sites in unit-cell lengths, site 1 first; the wall is at 0.
    v : (N,) numbers
        Velocities of the sites, in long-wave sound speeds of the uniform chain.
    hold : bool
        Whether the first site stays where it is, as a wall.

    Raises
    ------
    ValueError
        Where they are no numbers from -1e6 to 1e6, not as many, or all 0, or a held site is to move.

    Examples
    --------
    >>> import kernel
    >>> event = kernel.Release(u=[0.0] * 20, v=[0.1] + [0.0] * 19)
    >>> round(kernel.Scene(20, 0.0, event, observe="energy").TE, 12)
    0.005
    """

    u: Any
    v: Any
    hold: bool = False

    def __post_init__(self) -> None:
        problems = []
        for name in ("u", "v"):
            values = finite_numbers(getattr(self, name))
            if values is None or np.abs(values).max() > LARGEST:
                rule = f"must hold numbers from {-LARGEST:g} to {LARGEST:g}, one for each site"
                problems.append(f"{name}: {rule}, got {shown(getattr(self, name))}")
            else:
                values.flags.writeable = False
                object.__setattr__(self, name, values)  # frozen: there is no other way
        if not problems and len(self.u) != len(self.v):
            problems.append(f"u, v: must be as many, got {len(self.u)} and {len(self.v)}")
        if not problems and max(np.abs(self.u).max(), np.abs(self.v).max()) < LEAST:
            problems.append(f"u, v: must not all be 0, or below {LEAST:g} in magnitude")
        problems += breaking(FLAG, hold=self.hold)
        if not problems and self.hold and self.v[0] != 0.0:
            problems.append(f"v: must be 0 for the first site, which is held, got {self.v[0]:g}")
        if problems:
            raise ProblemsError(problems)

    def motion(self, N: int) -> DriverMotion | None:
        """As the compiled code takes it: rest, where the first site is held."""
        return REST._replace(places=np.array(self.u[:1]), holds=True) if self.hold else None


# In place of wrong arguments, while options are judged that these break in no way: no event lasts longer than this one.
SOUND: dict[str, Any] = {"N": 1000, "zeta_T": 0.0, "event": Impact(1, 1), "law": SCENE_LAWS[0]}


@dataclass(frozen=True)
class Scene:
    """What to simulate.

    `t_end`, `speed` and `TE` are in the units of its `chain`, which may be its own: a released chain's TE with
    stiffness=4.0 is a quarter of that with [4.0] * N. Times `chain.force` both are in k_T L^2 / N.

    Parameters
    ----------
    N : int
        Number of unit cells, 2 to 10 000; 200.0 is 200.
    zeta_T : float
        Bulk damping ratio, 0 to 10.
    event : Impact, Drive or Release
        What happens to the struck end, or from which state the chain starts.
    law : str
        Of the springs: "bistable", that is the model's own, or "linear".
    observe : str, names, or mapping of names to options
        What to record, for example {"ke_field": {"times": 400, "sites": 100}}; names, options, shapes and units stand
        in `kernel.observers`. Of a driven end it must be said: "peak_ke" needs an impact.
    model : Model
        The chain; the paper's by default.

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
    event: Impact | Drive | Release
    law: str = "bistable"
    observe: Iterable[str] | Mapping[str, Mapping[str, Any]] = ("peak_ke",)
    model: Model = PAPER_MODEL

    def __post_init__(self) -> None:
        if isinstance(self.observe, str):
            object.__setattr__(self, "observe", (self.observe,))
        elif isinstance(self.observe, Mapping):
            object.__setattr__(self, "observe", deepcopy(dict(self.observe)))  # the caller may change his own
        else:
            with suppress(TypeError):  # what is no sequence is told below
                object.__setattr__(self, "observe", tuple(self.observe))  # may be read only once
        problems = [line for name in ("N", "zeta_T") if (line := broken_rule(name, getattr(self, name)))]
        event: Any = self.event
        if not isinstance(event, Impact | Drive | Release):
            problems.append(f"event: must be an Impact, a Drive or a Release, got {shown(event)}")
        elif isinstance(event, Release) and is_finite(self.N) and len(event.u) != self.N:
            problems.append(f"event: must have as many displacements as there are sites, got {len(event.u)}")
        if not isinstance(self.law, str) or self.law not in SCENE_LAWS:
            problems.append(unknown("law", self.law, SCENE_LAWS))
        model: Any = self.model
        if not isinstance(model, Model):
            problems.append(f"model: must be a Model, got {shown(model)}")
        else:
            if self.law == LINEAR_LAW:
                problems += tried([lambda: check_comparable(model)], ValueError, lines_of)[1]
            if is_finite(self.N) and model.sites not in (None, self.N):
                problems.append(f"model: holds lists of {model.sites} numbers, one a site, got N = {shown(self.N)}")
        if not problems:
            object.__setattr__(self, "N", int(self.N))
            object.__setattr__(self, "zeta_T", float(self.zeta_T))
            problems += self._problems_of_energy()
        wrong = {line.partition(":")[0] for line in problems}
        problems += self._problems_of_observe(whole=not wrong)
        if wrong and wrong <= SOUND.keys():  # what else is wrong shows beside sound ones
            beside = tried([lambda: replace(self, **{name: SOUND[name] for name in wrong})], ValueError, lines_of)[1]
            of_sound_N = "event: must have as many", "model: holds lists"  # and not of what was given
            problems += [line for line in beside if line not in problems and not line.startswith(of_sound_N)]
        if problems:
            raise ProblemsError(problems)

    def _problems_of_energy(self) -> list[str]:
        """Where a released state is so strained that no float holds its energy, or has none, so that nothing moves."""
        if not isinstance(self.event, Release):
            return []
        try:
            energy = self._released_energy()
        except OverflowError:
            energy = math.inf
        told = f"event: its state must have a finite energy above 0, got {energy:g}"
        return [] if 0.0 < energy < math.inf else [told]

    def _problems_of_observe(self, whole: bool) -> list[str]:
        """Names that are none; options, which depend on the rest, only where the rest is `whole`."""
        asked: Any = self.observe
        if not isinstance(asked, Mapping | tuple) or not asked:
            return [f"observe: must name at least one of {', '.join(names())}, got {shown(asked)}"]
        problems = [unknown("observe", name, names()) for name in asked if not _is_one(name)]
        return problems + (problems_of(self._wanted(), self._observed()) if whole else [])

    def _wanted(self) -> dict[str, Any]:
        """The options of every observer that there is."""
        options = self.observe if isinstance(self.observe, Mapping) else {}
        return {name: options.get(name, {}) for name in self.observe if _is_one(name)}

    def observers(self) -> dict[str, Observer]:
        """New observers, by name, for one run."""
        scene = self._observed()
        return {name: made(name, scene, options) for name, options in self._wanted().items()}

    def _observed(self) -> Observed:
        longest = 1 / LEAST if self.event is SOUND["event"] else self.t_end
        return Observed(self.N, self.chain, longest, self.TE, self.is_struck)

    @cached_property
    def chain(self) -> Chain:
        """In the compiled code's units."""
        M, lattice = math.inf, self._lattice
        if isinstance(self.event, Impact):
            M = self.event.M_over_M0 * M0
        elif isinstance(self.event, Release):  # there is none: one of a site's mass stands for the units
            M = lattice.mass / self.N
        return (linear_chain if self.law == LINEAR_LAW else lattice_chain)(self.N, self.zeta_T, M, lattice)

    @property
    def _lattice(self) -> Lattice:
        return self.model.lattice(self.N, None if isinstance(self.event, Impact) else self.event.motion(self.N))

    @property
    def speed(self) -> float:
        """Of impactor or driven end at the start, in the chain's own long-wave sound speeds.

        Of a driver that follows a history its largest, of a released chain one site's with all its energy.
        """
        if isinstance(self.event, Release):
            return math.sqrt(2.0 * self._released_energy())
        if isinstance(self.event, Impact):
            return self.event.V_over_V0 * V0 / frequency_of(self._lattice)
        motion = self.event.motion(self.N)
        return self.event.speed / frequency_of(self._lattice) if motion is None else motion.top

    def _released_energy(self) -> float:
        """In the chain's own units."""
        chain, event = self.chain, self.event
        v, strains = event.v / chain.frequency, np.diff(event.u, append=0.0)  # type: ignore[union-attr]
        mass, stiffness = (along_chain(chain.varied, row, self.N) for row in (MASS, STIFFNESS))
        stored = [chain.spring.energy_at(float(e)) for e in strains]
        return 0.5 * float(mass @ v**2) + float(stiffness @ stored)

    @property
    def t_end(self) -> float:
        """Duration in the chain's own cell transit times."""
        if isinstance(self.event, Drive) and self.event.strain is not None:
            return self.N * (self.event.strain / self.speed)
        return self.chain.t_end

    @property
    def is_struck(self) -> bool:
        """Whether an impactor or a driver pushes the chain through the contact."""
        return isinstance(self.event, Impact) or (isinstance(self.event, Drive) and not self.event.hold)

    @property
    def TE(self) -> float:  # noqa: N802 (the model's name)
        """Initial total energy; infinite where the end is driven."""
        return 0.5 * self.chain.impactor_mass * (self.speed * self.speed)


def _is_one(name: object) -> bool:
    return isinstance(name, str) and name in names()
