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
    """Asked for before a run, filled by it as far as it comes."""

    times: Array  # (frames,), ascending, from 0 to the end of the run
    u: Array  # (frames, N) displacements of the sites; (1, N) where nobody asks for them: those of the last frame
    v: Array  # (frames, N) velocities
    impactor: Array  # (frames, 2): its displacement and velocity
    dissipated: Array  # (frames,): energy that the dampers have taken so far; nan where it is told by what is missing
    taken: NDArray[np.int64]  # (1,): frames that are taken


def new_film(times: Array, N: int, displacements: bool) -> Film:
    """Nothing seen yet."""
    n = len(times)
    u, v, impactor = np.empty((n if displacements else 1, N)), np.empty((n, N)), np.empty((n, 2))
    return Film(times, u, v, impactor, np.full(n, np.nan), np.zeros(1, np.int64))


def frames_of(film: Film, which: NDArray[np.intp]) -> Film:
    """Some frames of a film, in ascending order: the film itself where these are all."""
    if len(which) == len(film.times):
        return film
    u = film.u if len(film.u) < len(film.times) else film.u[which]
    times, v, impactor, dissipated = (x[which] for x in (film.times, film.v, film.impactor, film.dissipated))
    return Film(times, u, v, impactor, dissipated, np.array([len(which)]))


@jit
def due(film: Film, t: float) -> bool:
    """Whether the next frame is before t."""
    k = film.taken[0]
    return bool(k < film.times.shape[0] and film.times[k] < t)


@jit
def energies(chain: Chain, film: Film) -> Array:
    """(frames,): the total energy of each."""
    found = np.empty(len(film.times))
    for k in range(len(found)):
        found[k] = energy(chain, film.u[k], film.v[k], film.impactor[k, 0], film.impactor[k, 1])
    return found


@jit
def take(chain: Chain, film: Film, view: Any) -> None:
    """The next frame; view: the chain at its time, as kernel.quantities.View."""
    k = film.taken[0]
    u, position = film.u[k % len(film.u)], 0.0  # of the wall
    view.show(u, film.v[k])
    for i in range(chain.N - 1, -1, -1):
        position -= u[i]
        u[i] = position
    film.impactor[k, 0], film.impactor[k, 1] = position - view.gap(), view.velocity(0)
    film.taken[0] += 1


@jit
def rewind(film: Any) -> None:
    """Begin again."""
    if film is not None:
        film.taken[0] = 0


@jit
def take_last_frames(film: Any, chain: Chain, view: Any) -> None:
    """All that are left when the run is over: its end may lie a rounding before theirs."""
    if film is not None:
        while due(film, math.inf):
            take(chain, film, view)
