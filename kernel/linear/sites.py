"""Weakly damped chains: an exact banded two-step march in site space, the contact resolved inside each macro step.

Sites ahead of the wave front, and sites that can no longer move the middle before the end, are left alone. Impact
speed 1. Site i (from 1) is at index GHOSTS - 1 + i of the arrays of sites, which hold mirrored ones on each side.
"""

import math

import numpy as np

from kernel.jit import jit
from kernel.linear.contact import Contact, contact_step
from kernel.linear.peak import HALF
from kernel.linear.tables import GHOSTS, MOMENTS, NEAR_PADDED, ROW, ROW_HALF, TERMS_PADDED, H, Tables
from kernel.model import Array
from kernel.simd import WIDTH, element, load, splat, store, zeros
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET

FRONT = 1e-11  # displacement near the last active site that lets in more
FIRST_SITES, MORE_SITES, WATCHED = 2 * GHOSTS, 12, 8
U0, V0, HELD, ASLEEP = range(4)  # impactor: displacement, speed, mean force of the last step, time it cannot touch


@jit
def propagate(after: Array, now: Array, before: Array, tables: Tables, lo: int, hi: int) -> None:
    """after = T now - D before at indices lo..hi-1 (8 at least): sixteen at a time share a coefficient."""
    t, d, half_now, half_before = tables.now, tables.before, tables.half_now, tables.half_before
    i = lo
    while i + 2 * WIDTH <= hi:
        k = i + WIDTH
        a = t[0] * load(now, i) - d[0] * load(before, i)
        b = t[0] * load(now, k) - d[0] * load(before, k)
        for j in range(1, half_now + 1):
            c = splat(t[j])
            a = a + c * (load(now, i - j) + load(now, i + j))
            b = b + c * (load(now, k - j) + load(now, k + j))
        for j in range(1, half_before + 1):
            c = splat(d[j])
            a = a - c * (load(before, i - j) + load(before, i + j))
            b = b - c * (load(before, k - j) + load(before, k + j))
        store(after, i, a)
        store(after, k, b)
        i += 2 * WIDTH
    while i < hi:
        k = min(i, hi - WIDTH)  # the last eight overlap the eight before
        a = t[0] * load(now, k) - d[0] * load(before, k)
        for j in range(1, half_now + 1):
            a = a + t[j] * (load(now, k - j) + load(now, k + j))
        for j in range(1, half_before + 1):
            a = a - d[j] * (load(before, k - j) + load(before, k + j))
        store(after, k, a)
        i += WIDTH


@jit
def mirror(u: Array, N: int, wall: bool) -> None:
    """Ghosts of the free left end (even about 1/2) and, once the front is there, of the wall at N+1 (odd)."""
    for j in range(GHOSTS):
        u[GHOSTS - 1 - j] = u[GHOSTS + j]
    if wall:
        right = GHOSTS + N
        u[right] = 0.0
        for j in range(1, GHOSTS):
            u[right + j] = -u[right - j]


@jit
def free_motion(path: Array, tables: Tables, now: Array, before: Array, moments: Array) -> None:
    """Monomials (TERMS_PADDED,) of the motion of site 1 in the coming step if nothing pushes it."""
    table, near = tables.free, tables.near
    a = b = c = d = splat(0.0)
    for i in range(near):
        j = i * TERMS_PADDED
        k = (near + i) * TERMS_PADDED
        a = a + now[GHOSTS + i] * load(table, j)
        b = b + now[GHOSTS + i] * load(table, j + WIDTH)
        c = c + before[GHOSTS + i] * load(table, k)
        d = d + before[GHOSTS + i] * load(table, k + WIDTH)
    for i in range(MOMENTS):
        j = (2 * near + i) * TERMS_PADDED
        a = a + moments[i] * load(table, j)
        b = b + moments[i] * load(table, j + WIDTH)
    store(path, 0, a + c)
    store(path, WIDTH, b + d)


@jit
def respond(after: Array, table: Array, moments: Array) -> None:
    """Add the response of the sites near the struck end to the force moments."""
    for i in range(0, NEAR_PADDED, WIDTH):
        x = load(after, GHOSTS + i)
        for j in range(MOMENTS):
            x = x + moments[j] * load(table, j * NEAR_PADDED + i)
        store(after, GHOSTS + i, x)


@jit
def half_step_back(tables: Tables, now: Array, before: Array, middle: int) -> float:
    """Displacement of the site at index `middle` at t_n - H/2."""
    total, start = splat(0.0), middle - ROW_HALF
    for i in range(0, ROW, WIDTH):
        total = total + load(tables.middle_now, i) * load(now, start + i)
        total = total + load(tables.middle_before, i) * load(before, start + i)
    x = 0.0
    for i in range(WIDTH):
        x += element(total, i)
    return x


@jit
def reach(left: float, zeta: float) -> int:
    """Sites farther than this cannot move each other (1e-10) within the time left: front, its Airy tail, diffusion."""
    t = max(left, H)
    return int(t + 6.0 * t ** (1.0 / 3.0) + 6.0 + 7.0 * math.sqrt(2.0 * zeta * t))


@jit
def strike(impactor: Array, contact: Contact, path: Array, moments: Array, max_steps: int) -> int:
    """Move the impactor through a macro step along the free motion of site 1; contact steps taken."""
    impactor[U0], impactor[V0], taken = contact_step(
        path, impactor[U0], impactor[V0], contact, impactor[HELD], moments, max_steps
    )
    impactor[HELD] = max(moments[0] / H, 0.0) if taken > 0 else 0.0
    if taken == 0:  # no site is faster than sqrt(mass), by the energy
        gap = path[0] - (impactor[U0] - impactor[V0] * H)
        impactor[ASLEEP] = gap / (math.sqrt(contact.impactor_mass) + abs(impactor[V0])) - H
    return taken


@jit
def _front_moved(u: Array, front: int) -> bool:
    """Whether the wave is near the last active site."""
    top = 0.0
    for i in range(GHOSTS + front - WATCHED, GHOSTS + front):
        top = max(top, abs(u[i]))
    return top > FRONT


@jit
def march(
    N: int, contact: Contact, tables: Tables, t_stop: float, samples: Array, count: int, max_steps: int
) -> tuple[int, int, int]:
    """Write u_mid(i H/2) into samples[HALF + i] for i < count, an odd number; t_stop bounds what is still of interest.

    Returns the status, contact steps and site steps.
    """
    now, before, after = zeros(N + 2 * GHOSTS), zeros(N + 2 * GHOSTS), zeros(N + 2 * GHOSTS)
    moments, last_moments, path = np.zeros(MOMENTS), np.zeros(MOMENTS), zeros(TERMS_PADDED)
    impactor = np.zeros(4)
    impactor[V0] = 1.0
    site, front = (N + 1) // 2, min(N, FIRST_SITES)
    middle, last_step = GHOSTS - 1 + site, (count - 1) // 2
    steps, site_steps, was_pushed = 0, 0, False
    for k in range(last_step + 1):
        mirror(now, N, front == N)
        samples[HALF + 2 * k] = now[middle]
        if k > 0 and front + ROW_HALF > site:
            samples[HALF + 2 * k - 1] = half_step_back(tables, now, before, middle)
        if k == last_step:
            break
        far = reach(t_stop - k * H, contact.zeta)
        first, last = max(1, site - far - 1), min(front, site + far + 1)
        pushed = False
        if impactor[ASLEEP] > H:
            impactor[ASLEEP] -= H
            impactor[U0] += impactor[V0] * H
        elif first == 1:
            free_motion(path, tables, now, before, last_moments)
            taken = strike(impactor, contact, path, moments, max_steps - steps)
            steps += taken
            pushed = taken > 0
            if not math.isfinite(impactor[U0] + impactor[V0]):
                return NOT_FINITE, steps, site_steps
            if steps >= max_steps:
                return STEP_BUDGET, steps, site_steps
        propagate(after, now, before, tables, GHOSTS - 1 + first, GHOSTS + last)
        site_steps += last - first + 1
        if pushed:
            respond(after, tables.response, moments)
        if was_pushed:
            respond(after, tables.response_before, last_moments)
        if not pushed:
            moments[:] = 0.0
        before, now, after = now, after, before
        moments, last_moments, was_pushed = last_moments, moments, pushed
        if front < N and _front_moved(now, front):
            front = min(N, front + MORE_SITES)
    return DONE, steps, site_steps
