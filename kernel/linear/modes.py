"""Exact modes, the contact force piecewise quadratic on adaptive steps.

A step is implicit in one number, the new force. Steps are the shortest one times powers of two, so that the modes'
responses are tabulated. Impact speed 1.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from kernel.jit import jit
from kernel.lend import borrowed, give_back
from kernel.linear.spectrum import TABLE_ROWS, Modes, doubled_table, step_table
from kernel.maxima import cubic_at, quintic_crest
from kernel.model import Array
from kernel.simd import WIDTH, element, load, splat, store, zeros
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET
from kernel.watch import part_of

LEVELS = 30  # doublings of the shortest step, at most
SPEED_MIN = 1e-6  # middle velocities below this need no resolution
FORCE_MIN = 0.02  # of the largest force so far: weaker ones need not be resolved relative to themselves
# A step whose error is beyond what is allowed is done again at half its size; at a quarter or an eighth where the error
# is ERROR_OF_A_LEVEL times, or this squared, as large.
ERROR_OF_A_LEVEL = 8.0
CALM_BELOW, CALM_STEPS = 0.2, 2  # after so many steps in a row with an error below it steps are twice as long
# In a lasting push steps are long against the contact's own relaxation. There the parabola through the last three
# forces multiplies an error of the force by -1.7 in every step (the stiff limit of Adams-Moulton's third-order
# formula); bent twice as much the other way, by a number of modulus 1/2: of second order, but then the steps follow the
# push alone.
RELAXATION_FROM = 1.0  # the contact's stiffness times the compliance in one step, from which it is bent so
RELAXED_SHARE = -2.0  # of what it is bent otherwise


class UnitImpact(NamedTuple):
    """Impactor, contact law and step rule, at impact speed 1."""

    contact: Any  # its law at unit speed
    impactor_mass: float  # N M
    force_bend: float  # second difference of the force allowed per step, over the force
    speed_bend: float  # the same of the middle velocity, over its maximum so far
    steps_per_collision: float  # of the first step
    longest: float  # step


class Motion(NamedTuple):
    """The state at t_n but the modes, and what the step control remembers."""

    u0: float  # impactor
    v0: float
    force: float
    force_before: float
    indentation: float
    middle: float  # velocity of the watched site
    middle_before: float
    dt_before: float
    top_force: float  # largest so far
    top_middle: float


@jit
def advance(table: Array, q: Array, q_next: Array, modes: Modes, force: float, curvature: float) -> tuple[float, float]:
    """The known part of a step; q: (2 * modes,), displacements and then velocities of the modes.

    Returns what it makes of the displacement of site 1 and the velocity of the middle.
    """
    n = modes.angle.shape[0]
    u1, v_mid = splat(0.0), splat(0.0)
    for i in range(0, n, WIDTH):
        x, y = load(q, i), load(q, n + i)
        a = load(table, i) * x + load(table, n + i) * y
        b = load(table, 2 * n + i) * x + load(table, 3 * n + i) * y
        a = a + (force * load(table, 4 * n + i) + curvature * load(table, 8 * n + i))
        b = b + (force * load(table, 6 * n + i) + curvature * load(table, 9 * n + i))
        store(q_next, i, a)
        store(q_next, n + i, b)
        u1 = u1 + load(modes.first, i) * a
        v_mid = v_mid + load(modes.middle, i) * b
    u, v = 0.0, 0.0
    for i in range(WIDTH):
        u += element(u1, i)
        v += element(v_mid, i)
    return u, v


@jit
def add_force(
    table: Array, q_next: Array, modes: Modes, zeta: float, force: float, curvature: float
) -> tuple[float, float]:
    """Add the part of the new force and of its share of the curvature.

    Returns acceleration and jerk of the watched site but for what the force on site 1 makes of them.
    """
    n, back, further = q_next.shape[0] // 2, splat(0.0), splat(0.0)
    for i in range(0, n, WIDTH):
        a = load(q_next, i) + (force * load(table, 5 * n + i) + curvature * load(table, 8 * n + i))
        b = load(q_next, n + i) + (force * load(table, 7 * n + i) + curvature * load(table, 9 * n + i))
        store(q_next, i, a)
        store(q_next, n + i, b)
        held = load(modes.held, i)
        pull = 2.0 * zeta * b + a
        back = back + held * pull
        further = further + (held * b - 2.0 * zeta * (load(modes.held_twice, i) * pull))
    acceleration, jerk = 0.0, 0.0
    for i in range(WIDTH):
        acceleration -= element(back, i)
        jerk -= element(further, i)
    return acceleration, jerk


@jit
def _set_gains(table: Array, modes: Modes, gain: Array) -> None:
    """gain (4,): displacement of site 1 and velocity of the middle per unit new force, then per unit curvature."""
    n = modes.angle.shape[0]
    gain[:] = 0.0
    for k in range(n):
        gain[0] += modes.first[k] * table[5 * n + k]
        gain[1] += modes.first[k] * table[8 * n + k]
        gain[2] += modes.middle[k] * table[7 * n + k]
        gain[3] += modes.middle[k] * table[9 * n + k]


@jit
def attempt(
    m: Motion, impact: UnitImpact, modes: Modes, table: Array, gain: Array, dt: float, q: Array, q_next: Array
) -> tuple[Motion, float, float]:
    """One step of dt: the motion at its end, its error over what is allowed, and the new force's curvature.

    The force is the line between its ends plus curvature * x (x - 1), a share of the second difference over two steps;
    the impactor takes -F/mass integrated twice. q_next still lacks the new force.
    """
    lightness = 1.0 / impact.impactor_mass
    slope = (m.force - m.force_before) * dt / m.dt_before
    share = dt / (dt + m.dt_before) if m.force > 0.0 else 0.0  # curvature = known + share * (new force)
    if impact.contact.stiffness_at(m.indentation) * (gain[0] + dt * dt * lightness / 6.0) > RELAXATION_FROM:
        share *= RELAXED_SHARE
    known = -share * (m.force + slope)
    u1, v_mid = advance(table, q, q_next, modes, m.force, known)
    guess = impact.contact.after(m.indentation, slope) if m.force > 0.0 else 0.0
    u0 = m.u0 + dt * m.v0 - dt * dt * lightness * (m.force / 3.0 - known / 12.0)
    own = dt * dt * lightness * (1.0 / 6.0 - share / 12.0)
    indentation = impact.contact.overlap(u0 - u1, gain[0] + share * gain[1] + own, guess)
    force = impact.contact.push(indentation)
    apart = force == 0.0  # leaving contact: back to a line that ends at zero
    curvature = -known if apart else share * force
    middle = v_mid + gain[2] * force + gain[3] * curvature
    u0 -= dt * dt * lightness * known / 12.0 if apart else own * force
    v0 = m.v0 - dt * lightness * (0.5 * (m.force + force) - (known + curvature) / 6.0)

    error = 0.0
    if m.force > 0.0 or force > 0.0:
        allowed = impact.force_bend * (max(m.force, force) + FORCE_MIN * m.top_force)
        error = abs(force - m.force - slope) / allowed
    bend = abs(middle - m.middle - (m.middle - m.middle_before) * dt / m.dt_before)
    error = max(error, bend / (impact.speed_bend * max(m.top_middle, abs(middle), SPEED_MIN)))
    top_force, top_middle = max(m.top_force, force), max(m.top_middle, abs(middle))
    end = Motion(u0, v0, force, m.force, indentation, middle, m.middle, dt, top_force, top_middle)
    return end, error, curvature


@jit
def _lower(level: int, error: float) -> int:
    """Level to try next after a step with an error above 1."""
    fall = 1 if error < ERROR_OF_A_LEVEL else 2 if error < ERROR_OF_A_LEVEL * ERROR_OF_A_LEVEL else 3
    return max(0, level - fall)


@jit
def crest_of_step(
    t: float,
    dt: float,
    t_end: float,
    v0: float,
    v1: float,
    a0: float,
    a1: float,
    jerk0: float,
    jerk1: float,
) -> tuple[float, float]:
    """Largest speed of the watched site in a step from t, and its time; what comes after t_end does not count."""
    speed, where = quintic_crest(dt, v0, v1, a0, a1, jerk0, jerk1)
    if t + where * dt > t_end:
        v = cubic_at((t_end - t) / dt, dt, v0, v1, a0, a1)
        return max(abs(v0), abs(v)), t_end if abs(v) > abs(v0) else t
    return speed, t + where * dt


@jit
def march(
    modes: Modes, zeta: float, impact: UnitImpact, t_end: float, max_steps: int, crests: Array
) -> tuple[int, int, float, float]:
    """Returns status, tried steps, largest speed of the watched site and its time; crests: of kernel.watch.Watch."""
    n = modes.angle.shape[0]
    shortest = impact.contact.duration(1.0 + 1.0 / impact.impactor_mass, 1.0) / impact.steps_per_collision
    highest = int(min(LEVELS - 1.0, max(0.0, math.log2(impact.longest / shortest))))
    own = np.empty((highest + 1, TABLE_ROWS * n)), np.empty((highest + 1, 4)), zeros(2 * n), zeros(2 * n)
    (tables, gains, q, q_next), lent = borrowed(own), borrowed(modes)
    step_table(lent.angle, zeta, shortest, tables[0])
    _set_gains(tables[0], lent, gains[0])
    m = Motion(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, shortest, 0.0, 0.0)
    t, level, tabulated, tried, calm = 0.0, 0, 0, 0, 0
    a0, jerk0, best, t_best = 0.0, 0.0, 0.0, 0.0  # of the watched site, and its largest speed
    while t < t_end:
        if tried >= max_steps:
            return STEP_BUDGET, tried, best, t_best
        if tabulated < level:
            doubled_table(tables[tabulated], tables[level])
            _set_gains(tables[level], lent, gains[level])
            tabulated = level
        dt = shortest * 2.0**level
        end, error, curvature = attempt(m, impact, lent, tables[level], gains[level], dt, q, q_next)
        tried += 1
        if not math.isfinite(error + end.u0 + end.v0):
            return NOT_FINITE, tried, best, t_best
        if error > 1.0 and level > 0:
            level, calm = _lower(level, error), 0
            continue
        a1, jerk1 = add_force(tables[level], q_next, lent, zeta, end.force, curvature)
        q, q_next = q_next, q
        part = part_of(t, t_end)
        if a0 * a1 < 0.0 or abs(end.middle) > crests[part]:
            speed, when = crest_of_step(t, dt, t_end, m.middle, end.middle, a0, a1, jerk0, jerk1)
            crests[part] = max(crests[part], speed)
            if speed > best:
                best, t_best = speed, when
        t, m, a0, jerk0 = t + dt, end, a1, jerk1
        calm = calm + 1 if error < CALM_BELOW else 0
        if calm >= CALM_STEPS and level < highest:
            level, calm = level + 1, 0
    give_back(own)
    return DONE, tried, best, t_best
