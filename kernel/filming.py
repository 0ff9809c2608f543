"""A scene's run, filmed: by the splittings where these serve, else by Dormand-Prince."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from kernel import rk45
from kernel.film import Film
from kernel.integrate import run_by
from kernel.method import AUTO, DORMAND_PRINCE, IMPLICIT, MODES, Integrator, methods_of, suited_to
from kernel.model import Array, Chain
from kernel.observers import End, Observer
from kernel.run import Run
from kernel.scene import Drive, Impact, Release, Scene
from kernel.status import DONE
from kernel.varied import DAMPING, LIGHTNESS, STIFFNESS, DriverMotion, along_chain, driven_acceleration
from kernel.watch import WHEN, Watch, largest_of, new_watch, told_by_splittings

FAR_AWAY = 1e9  # unit cells: where the impactor is when nothing strikes the chain


class Ran(NamedTuple):
    """What a run tells when it is over."""

    status: int  # kernel.status code
    steps: int
    site_evaluations: int
    end: End | None  # of a run that is done


def filmed(
    scene: Scene, integrator: Integrator, observers: Mapping[str, Observer]
) -> "_BySplitting | _ByDormandPrince":
    """The run that the scene and its accuracy ask for."""
    # Sorted: what was compiled for one scene serves others that name the same quantities in another order.
    asked = ((name, observer.quantity) for name, observer in sorted(observers.items()))
    quantities = {name: quantity for name, quantity in asked if quantity is not None}
    dissipation = any(observer.needs_dissipation for observer in observers.values())
    chain = scene.chain
    integrator = suited_to(0.0, integrator)  # all that happens on the chain is not told as well as its peak
    if integrator.kind == AUTO and isinstance(scene.event, Impact) and chain.varied is None:
        method = int(methods_of(chain.N, chain.zeta, chain.spring.is_linear(), integrator))
        told = not quantities or told_by_splittings(chain, quantities.values())
        if method != DORMAND_PRINCE and told:  # of the chain's modes the whole chain cannot be seen
            return _BySplitting(scene, IMPLICIT if method == MODES else method, integrator, quantities)
    return _ByDormandPrince(scene, integrator, quantities, dissipation)


class _BySplitting:
    """Each film is a run of its own: scenes of so many frames that there are several are rare."""

    def __init__(self, scene: Scene, method: int, integrator: Integrator, quantities: Mapping[str, Any]) -> None:
        self.method, self._integrator, self._names = method, integrator, tuple(quantities)
        self._chain, self._speed = scene.chain, scene.speed
        self._watch = new_watch(tuple(quantities.values()))
        self._run: Run | None = None

    def fill(self, film: Film) -> None:
        """Film the chain at its times, which are after those of the films before."""
        x, watch = self._integrator, self._watch._replace(film=film)
        self._run = run_by(self.method, self._chain, self._speed, 0.0, x.accuracy, x.max_steps, watch)

    def ended(self) -> Ran:
        run = self._run
        assert run is not None, "at least one film, be it empty, was asked for"
        found = largest_of(self._watch, self._chain, self._speed)
        end = End(run.speed, run.t, _largest(self._names, found, self._watch))
        return Ran(run.status, run.steps, run.site_evaluations, end if run.status == DONE else None)


class _ByDormandPrince:
    """One run, advanced from film to film."""

    method = DORMAND_PRINCE

    def __init__(self, scene: Scene, integrator: Integrator, quantities: Mapping[str, Any], dissipation: bool) -> None:
        self._chain, self._speed, self._names = scene.chain, scene.speed, tuple(quantities)
        chain, event, x = self._chain, scene.event, integrator
        motion = event.motion(scene.N) if isinstance(event, Drive) else None
        reached = 0.0 if isinstance(event, Release) or motion else rk45.REACHED * self._speed
        atol = x.atol * _size(scene, motion)
        self._settings = rk45.Settings(x.rtol, atol, x.max_steps, scene.t_end, reached, dissipation)
        self._run = rk45.start(chain, self._speed, self._settings, new_watch(tuple(quantities.values())))
        if isinstance(event, Release):
            _release(chain, self._run, event)
        elif motion:
            _drive(self._run, motion)
        if quantities and not scene.is_struck:
            rk45.look_at_start(chain, self._run)

    def fill(self, film: Film) -> None:
        rk45.take_frames(self._chain, self._run, self._settings, film)

    def ended(self) -> Ran:
        run = self._run
        rk45.advance(self._chain, run, self._settings, self._settings.t_end)
        status, steps, evaluations = (run.tally[k] for k in (rk45.STATUS, rk45.STEPS, rk45.SITE_EVALUATIONS))
        largest = _largest(self._names, rk45.found(self._chain, self._speed, run), run.watch)
        end = End(run.clock[rk45.PEAK], run.clock[rk45.T_PEAK], largest)
        return Ran(int(status), int(steps), int(evaluations), end if status == DONE else None)


def _largest(names: Iterable[str], found: Array, watch: Watch) -> dict[str, tuple[float, float]]:
    """The number of each quantity, and the time at which the run reached it."""
    return {name: (float(found[k]), float(watch.memory[k, WHEN])) for k, name in enumerate(names)}


def _size(scene: Scene, motion: DriverMotion | None) -> float:
    """How large displacements and velocities are, 1 at most: a driver or a first state may make them ever so small.

    Absolute tolerances go with it, so that a linear chain answers in proportion.
    """
    event = scene.event
    if isinstance(event, Release):
        return min(1.0, max(float(np.abs(event.u).max()), float(np.abs(event.v).max())))
    if isinstance(event, Drive):
        return min(1.0, motion.top if motion else scene.speed)
    return 1.0


def _release(chain: Chain, run: rk45.March, event: Release) -> None:
    """Put the chain into its first state, with its accelerations; the impactor is far away."""
    N, s, v = chain.N, run.s, event.v / chain.frequency
    s.u[:N], s.v[:N], s.impactor[:2] = event.u, v, (-FAR_AWAY, 0.0)
    e, of = np.diff(event.u, append=0.0), (STIFFNESS, DAMPING, LIGHTNESS)
    stiffness, damping, lightness = (along_chain(chain.varied, row, N) for row in of)
    pull = stiffness * (e + chain.spring.excess(e)) + 2.0 * chain.zeta * damping * np.diff(v, append=0.0)
    s.k[:N] = lightness * np.diff(pull, prepend=0.0)


def _drive(run: rk45.March, motion: DriverMotion) -> None:
    """Give the driver, or the site that it holds, its first velocity and acceleration."""
    s, speed, acceleration = run.s, float(motion.speeds[0]), driven_acceleration(motion, 0.0, 0.0)
    if motion.holds:
        s.v[0], s.k[0], s.impactor[:2] = speed, acceleration, (-FAR_AWAY, 0.0)
    else:
        s.impactor[1], s.k_impactor[0] = speed, acceleration
