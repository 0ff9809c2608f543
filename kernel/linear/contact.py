"""Impactor and first site inside one macro step, with the Hertz contact resolved.

The free motion of site 1 (no force within the step) is a polynomial of the fraction x = (t - t_n)/H; the response of
sites 1 to 3 to the force is stepped along with the impactor by position Verlet, farther sites do not answer within a
step. Impact speed 1.
"""

import math
from typing import NamedTuple

import numpy as np

from kernel.jit import jit
from kernel.linear.tables import MOMENTS, TERMS, H
from kernel.model import Array

NO_TOUCH = 2.0  # a fraction of the step beyond its end
# Hertz: an impact of relative speed v lasts 2.943 d/v, d the deepest indentation (Johnson, Contact Mechanics, 11.24).
# With v^2 = 0.8 k d^2.5 and omega^2 = 1.5 k d^0.5, the stiffness there, this is 4.03/omega.
COLLISION = 4.03
TINY = 1e-300  # keeps a quotient finite where both sides vanish


class Contact(NamedTuple):
    """Impactor, contact law and step rule, at impact speed 1."""

    stiffness: float  # K sqrt(V)
    impactor_mass: float  # N M
    zeta: float
    steps_per_collision: float
    calm: float  # share of them that is enough while the indentation hardly swings
    longest: float  # step


@jit
def value(path: Array, x: float) -> float:
    """The free motion of site 1 at fraction x; even and odd powers side by side. path: (TERMS,) or longer."""
    y = x * x
    even, odd = path[TERMS - 2], path[TERMS - 1]
    for k in range(TERMS - 4, -1, -2):
        even = even * y + path[k]
        odd = odd * y + path[k + 1]
    return even + x * odd


@jit
def slope(path: Array, x: float) -> float:
    """Derivative of value by x."""
    s = (TERMS - 1) * path[TERMS - 1]
    for k in range(TERMS - 2, 0, -1):
        s = s * x + k * path[k]
    return s


@jit
def _gap_root(path: Array, u0: float, advance: float, x0: float, gap0: float, x1: float, gap1: float) -> float:
    """Where u0 + advance x = value(path, x) between x0 (gap0 < 0) and x1 (gap1 > 0): Illinois rule."""
    x, side = x1, 0
    for _ in range(60):
        x = x0 - gap0 * (x1 - x0) / (gap1 - gap0)
        gap = u0 + advance * x - value(path, x)
        if abs(gap) < 1e-13 * (abs(u0) + abs(advance)):
            break
        if gap > 0.0:
            x1, gap1 = x, gap
            gap0 *= 0.5 if side == 1 else 1.0  # halve the end that stays
            side = 1
        else:
            x0, gap0 = x, gap
            gap1 *= 0.5 if side == -1 else 1.0
            side = -1
    return x


@jit
def first_touch(path: Array, u0: float, v0: float) -> float:
    """First fraction of the step at which the flying impactor reaches site 1; NO_TOUCH if none."""
    room = path[0] - u0 - max(v0, 0.0) * H
    for k in range(1, TERMS):
        room -= abs(path[k])
    if room > 0.0:
        return NO_TOUCH
    x0, gap0 = 0.0, u0 - path[0]
    for k in range(1, 9):
        x1 = 0.125 * k
        gap1 = u0 + v0 * H * x1 - value(path, x1)
        if gap1 > 0.0:
            return _gap_root(path, u0, v0 * H, x0, gap0, x1, gap1)
        x0, gap0 = x1, gap1
    return NO_TOUCH


@jit
def _step_length(contact: Contact, indentation: float, approach: float, held: float) -> float:
    """Step from the present collision's duration, longer while the indentation swings little about `held`."""
    k = contact.stiffness * (1.0 + 1.0 / contact.impactor_mass)
    d = max(indentation, 0.0)
    energy = 0.5 * approach * approach + 0.4 * k * d * d * math.sqrt(d)
    deepest = (2.5 * energy / k) ** 0.4
    omega = math.sqrt(1.5 * k * math.sqrt(max(deepest, held, TINY)))
    swing = max(abs(indentation - held), abs(approach) / omega)
    steps = contact.steps_per_collision * (1.0 if swing > 0.5 * held else contact.calm)
    return min(COLLISION / (steps * omega), contact.longest)


@jit
def _add_moments(moments: Array, impulse: float, x: float) -> None:
    """Add an impulse at fraction x of the step."""
    for j in range(MOMENTS):
        moments[j] += impulse
        impulse *= x


@jit
def contact_step(
    path: Array, u0: float, v0: float, contact: Contact, held_force: float, moments: Array, max_steps: int
) -> tuple[float, float, int]:
    """One macro step of the impactor at u0, v0 against site 1; held_force: the mean force of the step before.

    moments (MOMENTS,) receives those of the force. Returns u0, v0 at the end and the steps taken: 0 without touch, and
    `max_steps` when the step was broken off there.
    """
    for j in range(MOMENTS):
        moments[j] = 0.0
    t = 0.0
    if u0 <= path[0]:
        x = first_touch(path, u0, v0)
        if x > 1.0:
            return u0 + v0 * H, v0, 0
        t = x * H
        u0 += v0 * t
    stiffness, lightness, eta = contact.stiffness, 1.0 / contact.impactor_mass, 2.0 * contact.zeta
    held = (held_force / stiffness) ** (2.0 / 3.0)
    indentation = u0 - value(path, t / H)
    regular = _step_length(contact, indentation, v0 - slope(path, t / H) / H, held)
    regular = (H - t) / (np.floor((H - t) / regular) + 1.0)
    u1 = v1 = u2 = v2 = u3 = v3 = 0.0  # the sites' response to the force since t_n
    steps = 0
    while t < H - 1e-9 * H and steps < max_steps:
        dt = regular
        if indentation < 0.0:  # apart: no farther than about half the way to a touch
            approach = v0 - v1 - slope(path, t / H) / H
            dt = min(max(regular, -0.5 * indentation / (abs(approach) + TINY)), contact.longest)
        dt = min(dt, H - t)
        half = 0.5 * dt
        x = (t + half) / H
        u1 += half * v1
        u2 += half * v2
        u3 += half * v3
        u0 += half * v0
        indentation = u0 - u1 - value(path, x)
        impulse = 0.0
        if indentation > 0.0:
            impulse = stiffness * dt * indentation * math.sqrt(indentation)
            _add_moments(moments, impulse, x)
        # The dampers act on the velocities in the middle of the step, predicted, and during half of it on the impulse:
        # with the velocities at its start the order would be one.
        a1, a2, a3 = u2 - u1, u1 - 2.0 * u2 + u3, u2 - 2.0 * u3
        m1 = v1 + half * (a1 - eta * (v1 - v2))
        m2 = v2 + half * (a2 - eta * (2.0 * v2 - v1 - v3))
        m3 = v3 + half * (a3 - eta * (2.0 * v3 - v2))
        passed_on = half * eta  # share of the impulse
        v1 = (v1 + dt * (a1 - eta * (m1 - m2))) + (1.0 - passed_on) * impulse
        v2 = (v2 + dt * (a2 - eta * (2.0 * m2 - m1 - m3))) + passed_on * impulse
        v3 += dt * (a3 - eta * (2.0 * m3 - m2))
        v0 -= impulse * lightness
        u0 += half * v0
        u1 += half * v1
        u2 += half * v2
        u3 += half * v3
        t += dt
        steps += 1
        if impulse == 0.0:
            indentation = u0 - u1 - value(path, t / H)
    return u0, v0, steps
