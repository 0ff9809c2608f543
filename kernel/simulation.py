"""Run a scene: steps as large as the accuracy allows, the chain shown to the observers in between."""

import math
from dataclasses import dataclass

import numpy as np

from kernel import rk45
from kernel.hints import shown, unknown
from kernel.method import choose
from kernel.model import Chain
from kernel.notebook import ShownAsTable, words
from kernel.observers import Moment, Result
from kernel.scene import Drive, Release, Scene
from kernel.status import DONE, WORDS
from kernel.task import gathered
from kernel.varied import DAMPING, LIGHTNESS, STIFFNESS, Motion, along_chain, driven_acceleration
from kernel.watch import WHEN, new_watch

FAR = 1e9  # unit cells: where the impactor is when nothing strikes the chain


@dataclass(frozen=True, repr=False)  # its own would print every number of every array
class Simulation(ShownAsTable):
    """What `simulate` saw: `simulation["ke_field"]["ke"]`; shapes and units stand in `kernel.observers`.

    Attributes
    ----------
    status : str
        "done", or why the run ended early: what was not seen is nan.
    steps : int
        Accepted ones.
    site_evaluations : int
        Force evaluations, counting the sites that the wave had reached.
    observed : dict
        Of every observer its named arrays.
    """

    status: str
    steps: int
    site_evaluations: int
    observed: dict[str, Result]

    def __repr__(self) -> str:
        held = (
            f"{name} ({', '.join(f'{key}: {words(array)}' for key, array in arrays.items())})"
            for name, arrays in self.observed.items()
        )
        return f"Simulation(status={self.status!r}, steps={self.steps}, observed: {', '.join(held)})"

    def __getitem__(self, name: str) -> Result:
        """The arrays of one observer; ValueError where it was not asked for."""
        if name not in self.observed:
            raise ValueError(unknown("observed", name, self.observed))
        return self.observed[name]


def simulate(scene: Scene, accuracy: float = 1e-3) -> Simulation:
    """Integrate `scene` once, by Dormand-Prince 5(4), and return what it asks for.

    Parameters
    ----------
    scene : Scene
        The chain, what happens to it, and what to observe.
    accuracy : float
        Wanted relative error, 1e-8 to 0.1; the tolerances follow from it as those of ke_ratio by "rk45" do.

    Returns
    -------
    Simulation
        `simulation[name]`: the named arrays of one observer.

    Raises
    ------
    ValueError
        Naming every argument that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> scene = kernel.Scene(20, 1e-3, kernel.Impact(2, 2), observe={"energy": {"times": 10}})
    >>> seen = kernel.simulate(scene)
    >>> seen.status, seen["energy"]["total"].shape
    ('done', (10,))
    """
    integrator, _ = gathered(lambda: choose(accuracy=accuracy), lambda: _check_scene(scene))
    observers = scene.observers()
    watch = any(observer.needs_dissipation for observer in observers.values())
    chain, speed = scene.chain, scene.speed
    motion = chain.varied.motion if isinstance(scene.event, Drive) and chain.varied is not None else None
    reached = 0.0 if isinstance(scene.event, Release) or motion else rk45.REACHED * speed
    h_max = motion.longest_step if motion else math.inf
    settings = rk45.Settings(integrator.rtol, integrator.atol, integrator.max_steps, scene.t_end, reached, watch, h_max)
    asked = {name: observer.quantity for name, observer in observers.items() if observer.quantity is not None}
    run = rk45.start(chain, speed, settings, new_watch(tuple(asked.values())))
    if isinstance(scene.event, Release):
        _release(chain, run, scene.event)
    elif motion:
        _drive(run, motion)
    seen = dict.fromkeys(observers, 0)
    for t in np.unique(np.concatenate([observer.times for observer in observers.values()])):
        rk45.advance(chain, run, settings, t)
        if run.tally[rk45.STATUS] != DONE:
            break
        moment = _moment(chain, run, float(t), watch, tuple(asked), speed)
        for name, observer in observers.items():
            if seen[name] < len(observer.times) and observer.times[seen[name]] == t:
                observer.see(seen[name], moment)
                seen[name] += 1
    return Simulation(
        WORDS[run.tally[rk45.STATUS]],
        int(run.tally[rk45.STEPS]),
        int(run.tally[rk45.SITE_EVALUATIONS]),
        {name: observer.result() for name, observer in observers.items()},
    )


def _check_scene(scene: object) -> None:
    if not isinstance(scene, Scene):
        raise ValueError(f"scene: must be a Scene, got {shown(scene)}")


def _release(chain: Chain, run: rk45.March, event: Release) -> None:
    """Put the chain into its first state, with its accelerations; the impactor is far away."""
    N, s, v = chain.N, run.s, event.v / chain.frequency
    s.u[:N], s.v[:N], s.impactor[:2] = event.u, v, (-FAR, 0.0)
    e, of = np.diff(event.u, append=0.0), (STIFFNESS, DAMPING, LIGHTNESS)
    stiffness, damping, lightness = (along_chain(chain.varied, row, N) for row in of)
    pull = stiffness * (e + chain.spring.excess(e)) + 2.0 * chain.zeta * damping * np.diff(v, append=0.0)
    s.k[:N] = lightness * np.diff(pull, prepend=0.0)


def _drive(run: rk45.March, motion: Motion) -> None:
    """Give the driver, or the site that it holds, its first velocity and acceleration."""
    s, speed, acceleration = run.s, float(motion.speeds[0]), driven_acceleration(motion, 0.0)
    if motion.holds:
        s.v[0], s.k[0], s.impactor[:2] = speed, acceleration, (-FAR, 0.0)
    else:
        s.impactor[1], s.k_impactor[0] = speed, acceleration


def _moment(chain: Chain, run: rk45.March, t: float, watch: bool, quantities: tuple[str, ...], speed: float) -> Moment:
    """The chain at t, which lies within the last step."""
    u, v = np.empty(chain.N), np.empty(chain.N)
    t_from = run.clock[rk45.T_FROM]
    h = run.clock[rk45.T] - t_from
    theta = (t - t_from) / h if h > 0.0 else 0.0
    now = run.tally[rk45.NOW]
    impactor = rk45.state_within(run.s, now, h, theta, u, v)
    taken = run.dissipated[0] + rk45.dissipated_within(chain, run.s, now, h, theta) if watch else np.nan
    found = rk45.found(chain, speed, run)
    largest = {name: (float(found[k]), float(run.watch.memory[k, WHEN])) for k, name in enumerate(quantities)}
    return Moment(t, u, v, impactor, taken, run.clock[rk45.PEAK], run.clock[rk45.T_PEAK], largest)
