"""What a chain has that is not uniform: numbers of each site and link, an end without a wall, a driver that moves.

Dormand-Prince alone knows such chains (kernel.stages). A free end is a last link without stiffness and damper, a driven
first site one that no force moves: nothing else in the kernel asks for them.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.simd import WIDTH, load, splat, zeros

Array = NDArray[np.float64]


class DriverMotion(NamedTuple):
    """The velocity of a driver: straight pieces through `speeds` at `times`, and a sine that ends.

    In long-wave sound speeds and cell transit times of the uniform chain.
    """

    times: Array  # (k,) ascending from 0; after the last one the last speed stays
    speeds: Array  # (k,)
    places: Array  # (k,) where the driver is at these times, in unit-cell lengths: the integral of the straight pieces
    amplitude: float
    omega: float
    until: float  # when the sine ends
    longest_step: float  # with which nothing of the sine is overlooked
    top: float  # largest speed
    holds: bool  # the first site moves so; else a driver does, which pushes it through the contact


class Varied(NamedTuple):
    """Numbers of every site i, at i - 1 of their row, and of the link to its right, over those of the uniform chain."""

    rows: Array  # (VARIED_ROWS padded(N),), row after row, whole packs each
    motion: DriverMotion


# Mass of each site; one over it, 0 behind the last site and of one that a driver holds; stiffness and damping of each
# link; 1 for the site that a driver holds, else 0.
MASS, LIGHTNESS, STIFFNESS, DAMPING, HELD, VARIED_ROWS = range(6)
REST = DriverMotion(np.zeros(1), np.zeros(1), np.zeros(1), 0.0, 0.0, 0.0, math.inf, 0.0, False)


def varied_of(mass: Array, stiffness: Array, damping: Array, free: bool, motion: DriverMotion | None) -> Varied:
    """Of sites, links and dampers with these numbers, each (N,)."""
    N = len(mass)
    rows = zeros(VARIED_ROWS * ((N + WIDTH - 1) // WIDTH * WIDTH)).reshape(VARIED_ROWS, -1)
    rows[MASS] = 1.0
    for row, values in ((MASS, mass), (LIGHTNESS, 1.0 / mass), (STIFFNESS, stiffness), (DAMPING, damping)):
        rows[row, :N] = values
    if free:
        rows[[STIFFNESS, DAMPING], N - 1] = 0.0
    if motion is not None and motion.holds:
        rows[LIGHTNESS, 0], rows[HELD, 0] = 0.0, 1.0
    return Varied(rows.ravel(), REST if motion is None else motion)


@jit
def driven_acceleration(motion: DriverMotion, t: float, within: float) -> float:
    """Acceleration of the driver at time t, by the piece of its motion that holds the time `within`: t, or one near."""
    times, speeds = motion.times, motion.speeds
    a = motion.amplitude * motion.omega * math.cos(motion.omega * t) if within < motion.until else 0.0
    k = np.searchsorted(times, within, side="right")
    if 0 < k < len(times):
        a += (speeds[k] - speeds[k - 1]) / (times[k] - times[k - 1])
    return a


@jit
def driven_place(motion: DriverMotion, t: float) -> tuple[float, float]:
    """Where the driver is at time t, and its velocity; integrated from its acceleration both would drift."""
    times, speeds = motion.times, motion.speeds
    k = np.searchsorted(times, t, side="right") - 1
    u, v, dt, phase = motion.places[k], speeds[k], t - times[k], motion.omega * min(t, motion.until)
    a = (speeds[k + 1] - v) / (times[k + 1] - times[k]) if k + 1 < len(times) else 0.0
    u, v = u + dt * (v + 0.5 * a * dt), v + a * dt
    if motion.omega > 0.0:
        u += 2.0 * motion.amplitude / motion.omega * math.sin(0.5 * phase) ** 2
        v += motion.amplitude * math.sin(phase) if t < motion.until else 0.0
    return u, v


@jit
def longest_step(varied: Any, t: float, least: float) -> float:
    """The longest step from time t on: to where this piece of a driver's motion ends, and short enough for a sine.

    A piece that ends within `least` is passed over.
    """
    if varied is None:
        return math.inf
    motion = varied.motion
    longest = motion.longest_step if t < motion.until else math.inf
    k = np.searchsorted(motion.times, t + least, side="right")
    return min(longest, motion.times[k] - t) if k < len(motion.times) else longest


def along_chain(varied: Any, row: int, N: int) -> Array:
    """A number of all sites or links, (N,)."""
    return np.ones(N) if varied is None else np.asarray(varied.rows.reshape(VARIED_ROWS, -1)[row, :N])


# A uniform chain has none of it: numba leaves out what is said of the others, as it compiles.
@jit
def own(varied: Any, row: int, i: int) -> float:
    """The number in this row of site, or of link, i = 1..N."""
    if varied is None:
        return 1.0
    return varied.rows[row * (varied.rows.shape[0] // VARIED_ROWS) + i - 1]


@jit
def is_driven(varied: Any) -> bool:
    """Whether a driver moves as told, and with it what strikes the chain or the first site."""
    if varied is None:
        return False
    return varied.motion.top > 0.0


@jit
def as_pushed(varied: Any, t: float, u: float, v: float) -> tuple[float, float]:
    """Place and speed of what strikes the chain: a driver's at time t as told, an impactor's these."""
    if varied is None:
        return u, v
    if varied.motion.top > 0.0 and not varied.motion.holds:
        return driven_place(varied.motion, t)
    return u, v


@jit
def as_held(varied: Any, t: float, u: Any, w: Any, x: float, y: float) -> Any:
    """u and w = x u + y v of the first eight sites; a first site that a driver holds moves as the driver does at t."""
    if varied is None:
        return u, w
    if varied.motion.holds:
        place, speed = driven_place(varied.motion, t)
        held = load(varied.rows, HELD * (varied.rows.shape[0] // VARIED_ROWS))
        others = splat(1.0) - held
        return others * u + held * place, others * w + held * (x * place + y * speed)
    return u, w


@jit
def hold(varied: Any, t: float, u: Array, v: Array) -> None:
    """Put the first of these sites, if it is held, to where it is told to be at time t."""
    if varied is not None and varied.motion.holds:
        u[0], v[0] = driven_place(varied.motion, t)
