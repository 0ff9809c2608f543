"""Run a scene: steps as large as the accuracy allows, the chain filmed for the observers."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from kernel.film import new_film
from kernel.filming import filmed
from kernel.hints import shown, unknown
from kernel.method import ACCURACY, FAR, MAX_STEPS, METHOD_WORDS, Integrator, choose, looser
from kernel.notebook import ShownAsTable, words
from kernel.observers import Result
from kernel.scene import Scene
from kernel.status import WORDS
from kernel.task import check, gathered

FRAME_NUMBERS = 2**23  # sites of all frames of one film: its displacements and velocities take 128 MB


# A dataclass would print every number of every array, and compare arrays as one.
@dataclass(frozen=True, repr=False, eq=False)
class Simulation(ShownAsTable):
    """What `simulate` saw: `simulation["ke_field"]["ke"]`; shapes and units stand in `kernel.observers`.

    Attributes
    ----------
    status : str
        "done", or why the run ended early: what was not seen is nan.
    method : str
        That integrated the chain.
    steps : int
        Accepted ones.
    site_evaluations : int
        Force evaluations, counting the sites that the wave had reached; both of the companion run too, if there is one.
    observed : dict
        Of every observer its named arrays.
    errors : dict
        Of a certified scene, for each array of every observer: its estimated error, over the largest magnitude in it.
    """

    status: str
    method: str
    steps: int
    site_evaluations: int
    observed: dict[str, Result]
    errors: dict[str, dict[str, float]] = field(default_factory=dict)

    def __repr__(self) -> str:
        held = (
            f"{name} ({', '.join(f'{key}: {words(array)}' for key, array in arrays.items())})"
            for name, arrays in self.observed.items()
        )
        how = f"status={self.status!r}, method={self.method!r}, steps={self.steps}"
        return f"Simulation({how}, observed: {', '.join(held)})"

    def __getitem__(self, name: str) -> Result:
        """The arrays of one observer; ValueError where it was not asked for."""
        if name not in self.observed:
            raise ValueError(unknown("observed", name, self.observed))
        return self.observed[name]

    def __iter__(self) -> Iterator[str]:
        """The names of the observers."""
        return iter(self.observed)


def simulate(
    scene: Scene,
    accuracy: float = ACCURACY,
    method: str = "auto",
    *,
    max_steps: int = MAX_STEPS,
    certify: bool = False,
) -> Simulation:
    """Integrate `scene` and return what it asks for.

    Parameters
    ----------
    scene : Scene
        The chain, what happens to it, and what to observe.
    accuracy : float
        Wanted relative error of the middle site's peak energy, 1e-8 to 0.1; steps follow from it as those of a
        certified ke_ratio do. Other sites and moments may be more sensitive, those near the struck end after it has
        been hit again most: `certify` tells by how much.
    method : str
        "auto": an impact on a uniform chain by the method that `ke_ratio` takes, everything else by Dormand-Prince
        5(4), as are quantities named under Returns; "rk45": Dormand-Prince in any case.
    max_steps : int
        Tried steps, 1 to 10**15, after which the run ends and its status says so: a slow driver takes any number. Where
        the explicit splitting serves, a step in which the impactor touches the chain is asked for as a whole: the run
        may end by its substeps later.
    certify : bool
        Whether to run a companion of ten times the accuracy too, or of four times the tolerances of Dormand-Prince:
        what differs between the two is the estimated error of each array (`errors`). Of 300 random impacts it covers
        86 to 99 % of the errors, and three times it 97 to 100 % (python -m tests.scenes).

    Returns
    -------
    Simulation
        `simulation[name]`: the named arrays of one observer. What is observed changes neither method nor steps, with
        one exception: with quantities of a chain one of whose first four sites is watched "auto" is "rk45", as with
        quantities of your own that ask for it (`sees_impactor` in kernel.quantities).

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
    integrator, *_ = gathered(
        lambda: choose(method, accuracy, max_steps=max_steps),
        lambda: _check_scene(scene),
        lambda: check({"certify": certify}),
    )
    seen = _seen(scene, integrator)
    if not certify:
        return seen
    companion = _seen(scene, looser(integrator)._replace(accuracy=FAR * integrator.accuracy))
    sites = seen.site_evaluations + companion.site_evaluations
    return replace(seen, steps=seen.steps + companion.steps, site_evaluations=sites, errors=_errors(seen, companion))


def _errors(seen: Simulation, companion: Simulation) -> dict[str, dict[str, float]]:
    """How far the companion's arrays are off, over the largest magnitude of each; nan where either ended early."""
    errors = dict[str, dict[str, float]]()
    for name, arrays in seen.observed.items():
        errors[name] = {}
        for key, array in arrays.items():
            off, largest = np.abs(array - companion[name][key]).max(), np.abs(array).max()
            unknown = math.nan if array.ndim == 0 else 0.0  # of one number that both runs have as 0
            errors[name][key] = float(off / largest) if largest else math.inf if off else unknown
    return errors


def _seen(scene: Scene, integrator: Integrator) -> Simulation:
    """What one run sees."""
    observers = scene.observers()
    run = filmed(scene, integrator, observers)
    times = np.unique(np.concatenate([observer.times for observer in observers.values()]))
    displacements = any(observer.needs_displacements for observer in observers.values())
    for part in np.array_split(times, math.ceil(len(times) * scene.N / FRAME_NUMBERS) or 1):
        film = new_film(part, scene.N, displacements)
        run.fill(film)
        for observer in observers.values():
            observer.look(film)
    ran = run.ended()
    if ran.end is not None:
        for observer in observers.values():
            observer.end(ran.end)
    results = {name: observer.result() for name, observer in observers.items()}
    return Simulation(WORDS[ran.status], METHOD_WORDS[run.method], ran.steps, ran.site_evaluations, results)


def _check_scene(scene: object) -> None:
    if not isinstance(scene, Scene):
        raise ValueError(f"scene: must be a Scene, got {shown(scene)}")
