"""The chain at given times of a run: what scenes are drawn from.

A frame is the state at its own time, to which the integrator takes a copy of its last step's end: nothing is
interpolated between steps, within which a short push may begin and end, and no frame changes a step.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.model import Array, Chain, energy


class Film(NamedTuple):
    """Asked for before a run, filled by it: nan where the run has not come so far."""

    times: Array  # (frames,), ascending, from 0 to the end of the run
    u: Array  # (frames, N) displacements of the sites
    v: Array  # (frames, N) velocities
    impactor: Array  # (frames, 2): its displacement and velocity
    energy: Array  # (frames,): total
    dissipated: Array  # (frames,): energy that the dampers have taken so far
    taken: NDArray[np.int64]  # (1,): frames that are taken


def new_film(times: Array, N: int) -> Film:
    """Nothing seen yet."""
    n = len(times)
    u, v, impactor, energies, dissipated = (np.full(shape, np.nan) for shape in ((n, N), (n, N), (n, 2), n, n))
    return Film(times, u, v, impactor, energies, dissipated, np.zeros(1, np.int64))


def frames_of(film: Film, which: NDArray[np.intp]) -> Film:
    """Some frames of a film."""
    _, *states, _ = film
    u, v, impactor, energies, dissipated = (of_all[which] for of_all in states)
    return Film(film.times[which], u, v, impactor, energies, dissipated, np.array([len(which)]))


@jit
def is_asked_for(film: Any) -> bool:
    """Whether there is one; known as it is compiled."""
    return film is not None


@jit
def due(film: Film, t: float) -> bool:
    """Whether the next frame is before t."""
    k = film.taken[0]
    return bool(k < film.times.shape[0] and film.times[k] < t)


@jit
def keep_energy(chain: Chain, film: Film, k: int) -> float:
    """That of a frame whose state is taken."""
    film.energy[k] = energy(chain, film.u[k], film.v[k], film.impactor[k, 0], film.impactor[k, 1])
    return float(film.energy[k])


@jit
def take(chain: Chain, film: Film, view: Any, V: float) -> None:
    """The next frame, of an impact at speed V; view: the chain at its time, as kernel.quantities.View.

    What the dampers took is what is missing, as of the quantity `dissipated`.
    """
    k = film.taken[0]
    u, position = film.u[k], 0.0  # of the wall
    view.show(u, film.v[k])
    for i in range(chain.N - 1, -1, -1):
        position -= u[i]
        u[i] = position
    film.impactor[k, 0], film.impactor[k, 1] = position - view.gap(), view.velocity(0)
    missing = 0.5 * chain.impactor_mass * V * V - keep_energy(chain, film, k)
    film.dissipated[k] = max(0.0, missing) if chain.zeta > 0.0 else 0.0
    film.taken[0] += 1


@jit
def rewind(film: Any) -> None:
    """Begin again."""
    if film is not None:
        film.taken[0] = 0


@jit
def take_last_frames(film: Any, chain: Chain, view: Any, V: float) -> None:
    """All that are left when the run is over: its end may lie a rounding before theirs."""
    if film is not None:
        while due(film, math.inf):
            take(chain, film, view, V)
