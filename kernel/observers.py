"""What a scene can record. An observer names its times and keeps what it is shown then; the steps do not depend on it.

Units: times over N, energies over the initial total energy TE, velocities in long-wave sound speeds, forces in k_T L.
"""

import inspect
from collections.abc import Mapping
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.film import Film, energies, frames_of
from kernel.hints import did_you_mean, shown
from kernel.model import Array, Chain
from kernel.problems import ProblemsError, lines_of
from kernel.quantities import QUANTITIES, lacking
from kernel.task import finite_numbers, gathered, is_finite, is_whole
from kernel.varied import DAMPING, MASS, STIFFNESS, along_chain, driven_acceleration, own

Result = dict[str, NDArray[Any]]
NEVER = np.empty(0)  # times of what only the end of a run tells
TIMES = 400  # at which an observer looks unless told otherwise: more than a picture of some inches can show
ROUNDING = 1e-12  # relative, by which a time may lie behind the end of a run


class Observed(NamedTuple):
    """What an observer must know of its scene (kernel.scene.Scene, whose names these are)."""

    N: int
    chain: Chain
    t_end: float
    TE: float
    is_struck: bool


class End(NamedTuple):
    """What a finished run tells beside its frames."""

    peak_speed: float  # of the middle site
    t_peak: float
    largest: Mapping[str, tuple[float, float]]  # of each quantity that is asked for: its number, and when


class Observer:
    """Base: shown the chain at its `times`, some of them at once, and what a finished run tells."""

    needs_TE = True  # whether it makes sense only for an impact of finite energy
    needs_dissipation = False
    needs_displacements = False
    quantity: Any = None  # of kernel.quantities, that the run is to watch for this observer
    times: Array
    span: float  # N cell transit times of the uniform chain, in the chain's own; then its units of speed and force
    speed: float
    force: float
    _found: Result  # of what only the end of a run tells
    _shape: tuple[int, int] = (0, 0)
    _columns = 0

    @cached_property
    def _rows(self) -> Array:
        """What is kept of every moment: nan until it is seen. Not made before the run: a scene may be only checked."""
        return np.full(self._shape, np.nan)

    def _keep(self, rows: NDArray[np.intp], numbers: Array) -> None:
        """Keep what was seen at some moments; copied unless these are all, as such arrays are large."""
        if len(rows) == len(self.times):
            self._rows = numbers
        else:
            self._rows[rows] = numbers

    def __init__(self, scene: Observed, times: Array) -> None:
        if self.needs_TE and not np.isfinite(scene.TE):
            raise ValueError("needs an impact, not a driven end, as it is told over what the impactor brings")
        self.scene, self.times = scene, times
        chain = scene.chain
        self.span, self.speed, self.force = scene.N * chain.frequency, chain.frequency, chain.force

    def look(self, film: Film) -> None:
        """Take from a film what was taken at times of this observer."""
        taken = film.times[: film.taken[0]]
        at = np.searchsorted(taken, self.times)
        rows = np.flatnonzero(np.append(taken, np.nan)[at] == self.times)
        if len(rows):
            self.see(rows, frames_of(film, at[rows]))

    def see(self, rows: NDArray[np.intp], film: Film) -> None:
        """Keep what is wanted of these of its times."""

    def end(self, end: End) -> None:
        """Keep what is wanted of the end of the run; a run that ended early has none."""

    def result(self) -> Result:
        """Named arrays."""
        return self._found


class PeakKe(Observer):
    """`ke` (): largest m v^2/2 of the watched site over continuous time, over TE. `t` (): when, over N."""

    def __init__(self, scene: Observed) -> None:
        super().__init__(scene, NEVER)
        self._found = {"ke": np.array(np.nan), "t": np.array(np.nan)}

    def end(self, end: End) -> None:
        chain = self.scene.chain
        ke = own(chain.varied, MASS, chain.site) * end.peak_speed**2 / 2 / self.scene.TE
        self._found = {"ke": np.array(ke), "t": np.array(end.t_peak / self.span)}


class Largest(Observer):
    """Of a quantity of kernel.quantities: `value` (); `t` (): when it was reached, over N, or the end of the run.

    Steps follow the accuracy that is wanted of the middle site's energy; "rk45" takes shorter ones at the struck end.
    """

    def __init__(self, scene: Observed, name: str) -> None:
        self._name, self.quantity = name, QUANTITIES[name]
        self.needs_TE = self.quantity.unit() in ("TE", "m_im V")
        if hasattr(self.quantity, "needs_impactor") and not scene.is_struck:
            raise ValueError("needs an impactor, or a driver that may part from the chain")
        varied = scene.chain.varied
        if hasattr(self.quantity, "needs_free_site") and scene.chain.site == 1 and varied and varied.motion.holds:
            raise ValueError("needs a site that moves freely, and the first one, which is watched, is held")
        if lines := lacking(self.quantity, scene.chain.spring):
            raise ProblemsError(lines)
        super().__init__(scene, NEVER)
        self._found = {"value": np.array(np.nan), "t": np.array(np.nan)}

    def end(self, end: End) -> None:
        value, t = end.largest[self._name]
        self._found = {"value": np.array(value), "t": np.array(t / self.span)}


class _Field(Observer):
    """A row of numbers at equally spaced times: one of each of the `names`, or of each site or link."""

    names: tuple[str, ...] = ()

    def __init__(self, scene: Observed, times: int = TIMES) -> None:
        columns = self._columns or len(self.names)
        count = _count("times", times, 2)
        super().__init__(scene, np.linspace(0.0, scene.t_end, count))
        if count * columns > NUMBERS_MAX:
            raise ValueError(f"times x sites must be at most {NUMBERS_MAX}, got {count} x {columns}")
        self._shape = count, columns

    def result(self) -> Result:
        return {"t": self.times / self.span, **dict(zip(self.names, self._rows.T, strict=True))}

    def _result(self, name: str, **more: NDArray[Any]) -> Result:
        return {"t": self.times / self.span, name: self._rows, **more}


class KeField(_Field):
    """Space-time map (figures 2, 3, 7): `ke` (times, sites) of each site over TE, `t` (times,), `site` (sites,).

    Fewer columns than sites: each holds the largest of its neighbours, so that no pulse is missed, from `site` on.
    """

    def __init__(self, scene: Observed, times: int = TIMES, sites: int | None = None) -> None:
        count, columns = gathered(
            lambda: _count("times", times, 2),
            lambda: scene.N if sites is None else min(scene.N, _count("sites", sites, 1)),
        )
        self._columns = columns
        super().__init__(scene, count)
        self._first = np.arange(columns) * scene.N // columns
        self._mass = along_chain(scene.chain.varied, MASS, scene.N)

    def see(self, rows: NDArray[np.intp], film: Film) -> None:
        ke = film.v**2
        ke *= self._mass / (2 * self.scene.TE)
        all_sites = len(self._first) == self.scene.N
        self._keep(rows, ke if all_sites else np.maximum.reduceat(ke, self._first, axis=1))

    def result(self) -> Result:
        return self._result("ke", site=self._first + 1)


class Energy(_Field):
    """Figure 12: `total` and `dissipated` (times,) over TE, `t` (times,). Their sum stays 1.

    By "rk45" the dampers' power is integrated, so that the sum is a check; else `dissipated` is what is missing.
    """

    needs_dissipation = needs_displacements = True
    names = "total", "dissipated"

    def see(self, rows: NDArray[np.intp], film: Film) -> None:
        chain, TE = self.scene.chain, self.scene.TE
        total = energies(chain, film)
        missing = np.maximum(0.0, TE - total) if chain.zeta > 0.0 else np.zeros(len(rows))
        dissipated = np.where(np.isnan(film.dissipated), missing, film.dissipated)
        self._keep(rows, np.stack([total, dissipated], axis=1) / TE)


class ViscousForce(_Field):
    """Figures 9, 10: `force` (times, N) = 2 zeta d_i (v_{i+1} - v_i) of every link, `t` (times,), `link` (N,).

    zeta: N zeta_T; d_i: the model's `damping`, 1 in the paper's chain; v_{N+1} = 0. At a free end the last is 0.
    """

    needs_TE = False

    def __init__(self, scene: Observed, times: int = TIMES) -> None:
        self._columns = scene.N
        super().__init__(scene, times)
        self._eta = 2 * scene.chain.zeta * self.force * along_chain(scene.chain.varied, DAMPING, scene.N)

    def see(self, rows: NDArray[np.intp], film: Film) -> None:
        force = -film.v
        force[:, :-1] += film.v[:, 1:]  # the wall rests
        force *= self._eta
        self._keep(rows, force)

    def result(self) -> Result:
        return self._result("force", link=np.arange(1, self.scene.N + 1))


class Profile(Observer):
    """Figure 11: velocities `v` and displacements `u` (times, N) of all sites at the times `at` (over N).

    `t` (times,), `site` (N,).
    """

    needs_TE, needs_displacements = False, True

    def __init__(self, scene: Observed, at: Any = (0.5,)) -> None:
        span = scene.N * scene.chain.frequency
        end = scene.t_end / span
        t = finite_numbers([at] if is_finite(at) else at)
        if t is not None and t[-1] <= end * (1.0 + ROUNDING):
            t = np.minimum(t, end)  # a run's own end, which rounding may have put before the number that was asked for
        if t is None or not (np.all((t >= 0) & (t <= end)) and np.all(np.diff(t) > 0)):
            raise ValueError(f"at must hold increasing times over N from 0 to {end:g}, got {shown(at)}")
        super().__init__(scene, np.minimum(t * span, scene.t_end))
        self._shape = len(t), 2 * scene.N

    def see(self, rows: NDArray[np.intp], film: Film) -> None:
        self._keep(rows, np.hstack([self.speed * film.v, film.u]))

    def result(self) -> Result:
        v, u = np.hsplit(self._rows, 2)
        return {"t": self.times / self.span, "v": v, "u": u, "site": np.arange(1, self.scene.N + 1)}


class QuasiStatic(_Field):
    """Figure A1: `force` (times,) with which the end is pushed, `strain` (times,) of the whole chain.

    Meant for a scene whose end is driven slowly. Of a first site that is held: what holds it, above 0 where it pushes.
    """

    needs_TE, needs_displacements = False, True
    names = "strain", "force"

    def see(self, rows: NDArray[np.intp], film: Film) -> None:
        end, contact = film.u[:, 0], self.scene.chain.contact
        self._rows[rows, 0] = end / self.scene.N
        varied = self.scene.chain.varied
        if varied is not None and varied.motion.holds:
            self._rows[rows, 1] = self.force * self._holding(film)
        else:
            self._rows[rows, 1] = [self.force * contact.push(d) for d in (film.impactor[:, 0] - end).tolist()]

    def _holding(self, film: Film) -> Array:
        """(frames,): what moves the first site as told, beside what the first link pulls it with."""
        chain, N = self.scene.chain, self.scene.N
        mass, stiffness, damping = (along_chain(chain.varied, row, N)[0] for row in (MASS, STIFFNESS, DAMPING))
        a = np.array([driven_acceleration(chain.varied.motion, t, t) for t in film.times.tolist()])
        e, rate = (np.diff(x[:, :2])[:, 0] for x in (film.u, film.v))
        return np.asarray(mass * a - stiffness * (e + chain.spring.excess(e)) - 2.0 * chain.zeta * damping * rate)


OBSERVERS: dict[str, Any] = {
    "peak_ke": PeakKe,
    "ke": PeakKe,  # its name in columns: a scene, a spec and kernel.measure take both
    "ke_field": KeField,
    "energy": Energy,
    "viscous_force": ViscousForce,
    "profile": Profile,
    "quasi_static": QuasiStatic,
}


TIMES_MAX, NUMBERS_MAX = 1_000_000, 1_000_000_000


def names() -> tuple[str, ...]:
    """Everything that a scene can observe."""
    return (*OBSERVERS, *QUANTITIES)


def made(name: str, scene: Observed, options: Any) -> Observer:
    """A new observer of that name; ValueError naming every option that it does not know, and the rule of a value."""
    kind = OBSERVERS.get(name) or partial(Largest, name=name)
    known = [option for option in inspect.signature(kind).parameters if option not in ("scene", "name")]
    if not isinstance(options, Mapping):
        raise ValueError(f"its options ({', '.join(known) or 'it has none'}) must be a mapping, got {shown(options)}")
    there = f"there is {', '.join(known)}" if known else "it has none"
    strange = [option for option in options if option not in known]
    told = [f"has no option {shown(option)} ({there}){did_you_mean(str(option), known)}" for option in strange]
    try:
        observer: Observer = kind(scene, **{option: options[option] for option in options if option in known})
    except ValueError as error:
        raise ProblemsError([*told, *lines_of(error)]) from None
    if told:
        raise ProblemsError(told)
    return observer


def problems_of(wanted: Mapping[str, Any], scene: Observed) -> list[str]:
    """What is wrong with the options of the observers that are wanted."""
    problems = list[str]()
    for name, options in wanted.items():
        try:
            made(name, scene, options)
        except ValueError as error:
            problems.append(f"observe: {name}: {error}")
    return problems


def _count(name: str, value: Any, least: int) -> int:
    if not (is_whole(value) and least <= value <= TIMES_MAX):
        raise ValueError(f"{name} must be a whole number from {least} to {TIMES_MAX}, got {shown(value)}")
    return int(value)
