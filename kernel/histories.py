"""How a driver moves: the velocity histories of kernel.Drive. Speeds over the long-wave sound speed, times over N."""

import math
from typing import Any, NamedTuple

import numpy as np

from kernel.hints import shown
from kernel.task import ABOVE_0, NOT_0, breaking, is_finite
from kernel.varied import DriverMotion

STEPS_OF_A_SINE = 8.0  # at least so many steps of one half of it
SAMPLES_MAX = 1_000_000


class Constant(NamedTuple):
    """Always the same speed."""

    speed: float

    def motion(self, N: int, holds: bool) -> DriverMotion:
        return _straight(np.zeros(1), np.array([self.speed]), holds)

    def problems(self) -> list[str]:
        return breaking(NOT_0, speed=self.speed)


class Ramp(NamedTuple):
    """The speed rises evenly from 0 to `speed`, and stays.

    Parameters
    ----------
    speed : float
        In long-wave sound speeds, not 0; negative away from the chain.
    rise : float
        How long it rises, in cell transit times over N, above 0.

    Raises
    ------
    ValueError
        By the `kernel.Drive` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Drive(kernel.Ramp(0.1, 0.2)).speed
    Ramp(speed=0.1, rise=0.2)
    """

    speed: float
    rise: float

    def motion(self, N: int, holds: bool) -> DriverMotion:
        """In cell transit times."""
        return _straight(np.array([0.0, N * self.rise]), np.array([0.0, self.speed]), holds)

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        return breaking(NOT_0, speed=self.speed) + breaking(ABOVE_0, rise=self.rise)


class HalfSine(NamedTuple):
    """One half of a sine, then rest: the usual shock pulse.

    Parameters
    ----------
    speed : float
        At its top, in long-wave sound speeds, not 0.
    duration : float
        Of the half sine, in cell transit times over N, above 0.

    Raises
    ------
    ValueError
        By the `kernel.Drive` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Drive(kernel.HalfSine(speed=0.1, duration=0.5)).strain is None
    True
    """

    speed: float
    duration: float

    def motion(self, N: int, holds: bool) -> DriverMotion:
        """In cell transit times."""
        return _sine(self.speed, N * self.duration, N * self.duration, holds)

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        return breaking(NOT_0, speed=self.speed) + breaking(ABOVE_0, duration=self.duration)


class Harmonic(NamedTuple):
    """A sine without end; `Drive(.., hold=True)` lets it pull as well.

    Parameters
    ----------
    speed : float
        Amplitude of the velocity in long-wave sound speeds, not 0.
    period : float
        In cell transit times over N, above 0. The linear chain passes periods above pi, that is pi/N over N.

    Raises
    ------
    ValueError
        By the `kernel.Drive` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Drive(kernel.Harmonic(speed=0.01, period=0.1), hold=True).hold
    True
    """

    speed: float
    period: float

    def motion(self, N: int, holds: bool) -> DriverMotion:
        """In cell transit times."""
        return _sine(self.speed, 0.5 * N * self.period, math.inf, holds)

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        return breaking(NOT_0, speed=self.speed) + breaking(ABOVE_0, period=self.period)


class Samples(NamedTuple):
    """Straight from sample to sample, as of a measured velocity; the last speed stays.

    Parameters
    ----------
    times : (n,) numbers
        Ascending from 0, in cell transit times over N; at least two. For a jump give two as near as you like.
    speeds : (n,) numbers
        In long-wave sound speeds, not all 0.

    Raises
    ------
    ValueError
        By the `kernel.Drive` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Drive(kernel.Samples([0.0, 0.1, 0.2], [0.0, 0.05, 0.0])).speed.times
    (0.0, 0.1, 0.2)
    """

    times: Any
    speeds: Any

    def motion(self, N: int, holds: bool) -> DriverMotion:
        """In cell transit times."""
        return _straight(N * np.array(self.times), np.array(self.speeds), holds)

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        found = []
        for name, values in zip(self._fields, self, strict=True):
            if not (isinstance(values, tuple) and 2 <= len(values) <= SAMPLES_MAX and all(map(is_finite, values))):
                rule = f"must hold 2 to {SAMPLES_MAX} finite numbers"
                found.append(f"{name}: {rule}, got {shown(values)}")
        if found:
            return found
        if len(self.times) != len(self.speeds):
            found.append(f"times, speeds: must be as many, got {len(self.times)} and {len(self.speeds)}")
        if self.times[0] != 0.0 or any(a >= b for a, b in zip(self.times, self.times[1:], strict=False)):
            found.append(f"times: must ascend from 0, got {shown(self.times)}")
        if not any(self.speeds):
            found.append("speeds: must not all be 0")
        return found


HISTORIES = (Constant, Ramp, HalfSine, Harmonic, Samples)


def as_history(given: Any) -> Any:
    """A number as a constant speed, arrays as tuples of floats; anything else as it is."""
    if isinstance(given, Samples):
        return Samples(*(_as_tuple(x.tolist() if hasattr(x, "tolist") else x) for x in given))
    return given if isinstance(given, HISTORIES) else Constant(given)


def _as_tuple(given: Any) -> Any:
    return tuple(given) if isinstance(given, list | tuple) else given


def _straight(times: Any, speeds: Any, holds: bool) -> DriverMotion:
    places = np.concatenate([np.zeros(1), np.cumsum(0.5 * np.diff(times) * (speeds[1:] + speeds[:-1]))])
    return DriverMotion(times, speeds, places, 0.0, 0.0, 0.0, math.inf, float(np.abs(speeds).max()), holds)


def _sine(speed: float, half: float, until: float, holds: bool) -> DriverMotion:
    times = np.array([0.0, until] if until < math.inf else [0.0])  # of the straight pieces beside it, which are at rest
    rest = np.zeros(len(times))
    return DriverMotion(times, rest, rest, speed, math.pi / half, until, half / STEPS_OF_A_SINE, abs(speed), holds)
