"""The modes of the free chain (left end free, wall at N+1) and their exact response over a time step.

Mode k = 1..N has the angle (2k - 1) pi/(2N + 1) and the frequency w = 2 sin(angle/2); its shape at site i is
cos((i - 1/2) angle). Driven by a force F at site 1 its amplitude obeys q'' + 2 a q' + w^2 q = F with a = zeta w^2.
"""

import cmath
import math
from typing import NamedTuple

import numpy as np

from kernel.jit import unfused_jit
from kernel.model import Array
from kernel.simd import WIDTH

GROUP_RATIO = 1.7  # of the last to the first mode of a group
SMOOTH_POINTS = 9  # of a group whose response does not oscillate: interpolated to 1e-8; with 7 to 1e-6
POINTS_PER_RADIAN = 0.5  # and of its response's variation over the group while felt; from 0.4 to 0.7 it is the same
ATTENUATIONS_FELT = 9.0  # attenuations e^-1 after which the response of a mode is not felt
POINTS_MAX = 1e6  # of a group, before it is made a whole number: more than any group has modes
WORTH_GROUPING = 1.2  # modes of a group over its points, below which the modes stand for themselves: little is saved
# Of a mode near critical damping: the square of half its roots' difference over that of a root, at the least. Its
# response is a difference divided by theirs, which then has a relative error of 1e-12.
ROOTS_APART = 1e-8
TABLE_ROWS = 10  # of a step table, see step_table


class Modes(NamedTuple):
    """Modes and groups of them, then modes without weight up to whole packs."""

    angle: Array
    first: Array  # weight of a mode in the displacement of site 1
    middle: Array  # weight in the velocity of the watched site
    held: Array  # the same times w^2, in its acceleration
    held_twice: Array  # times w^4, in its jerk
    number: int  # that have a weight


@unfused_jit
def _points(k: int, modes: int, N: int, zeta: float) -> int:
    """Nodes for the modes k .. k + modes - 1; as many as modes where fewer would not tell the motion."""
    if zeta <= 0.0:
        return modes
    variation = ATTENUATIONS_FELT * (GROUP_RATIO - 1.0) * (2 * N + 1) / (zeta * (2 * k - 1) * math.pi)
    points = int(min(POINTS_PER_RADIAN * variation, POINTS_MAX)) + SMOOTH_POINTS
    return points if WORTH_GROUPING * points < modes else modes


@unfused_jit
def _share(mode: int, place: Array, turn: Array, share: Array) -> None:
    """Share of each node, at `place`, in the value that the polynomial through all nodes has at this mode.

    The barycentric formula; turn: its weights for Chebyshev points, as of `_set_nodes` (Berrut and Trefethen 2004).
    """
    total = 0.0
    for j in range(place.shape[0]):
        if place[j] == mode:
            share[:] = 0.0
            share[j] = 1.0
            return
        share[j] = turn[j] / (mode - place[j])
        total += share[j]
    for j in range(place.shape[0]):
        share[j] /= total


@unfused_jit
def _set_nodes(k: int, modes: int, place: Array, turn: Array) -> None:
    """The nodes for the modes k .. k + modes - 1: these themselves, or as many Chebyshev points as `place` has room."""
    points = place.shape[0]
    for j in range(points):
        angle = (j + 0.5) * math.pi / points
        place[j] = k + (j if points == modes else 0.5 * (modes - 1) * (1.0 + math.cos(angle)))
        turn[j] = math.sin(angle) * (1.0 - 2.0 * (j % 2))


@unfused_jit
def chain_modes(N: int, zeta: float, mid: int) -> Modes:
    """The modes, high ones in groups: how a damped mode responds depends smoothly on its number.

    A group is told by the responses at a few nodes, through which a polynomial gives that of each of its modes: a node
    has the weights of all modes, times its share in each. So no mode is left out, at whatever site.
    """
    room = N + WIDTH
    modes = Modes(np.full(room, 1.0), np.zeros(room), np.zeros(room), np.zeros(room), np.zeros(room), 0)
    place, turn, share = np.empty(N), np.empty(N), np.empty(N)
    unit, norm, count, k = math.pi / (2 * N + 1), 4.0 / (2 * N + 1), 0, 1
    while k <= N:
        number = min(int((GROUP_RATIO - 1.0) * k) + 1, N - k + 1)
        points = _points(k, number, N, zeta)
        _set_nodes(k, number, place[:points], turn[:points])
        for j in range(points):
            modes.angle[count + j] = (2.0 * place[j] - 1.0) * unit
        for mode in range(k, k + number):
            _share(mode, place[:points], turn[:points], share[:points])
            angle = (2 * mode - 1) * unit
            first = norm * math.cos(0.5 * angle)
            middle = first * math.cos((mid - 0.5) * angle)
            first *= math.cos(0.5 * angle)
            for j in range(points):
                modes.first[count + j] += first * share[j]
                modes.middle[count + j] += middle * share[j]
        count += points
        k += number
    for j in range(count):
        w2 = 4.0 * math.sin(0.5 * modes.angle[j]) ** 2
        modes.held[j] = modes.middle[j] * w2
        modes.held_twice[j] = modes.held[j] * w2
    padded = (count + WIDTH - 1) // WIDTH * WIDTH
    return Modes(
        modes.angle[:padded],
        modes.first[:padded],
        modes.middle[:padded],
        modes.held[:padded],
        modes.held_twice[:padded],
        count,
    )


@unfused_jit
def _phi(z: complex) -> tuple[complex, complex, complex, complex]:
    """exp z, phi1, phi2 and 2 phi3 - phi2 for Re z <= 0; phi_j(z) = sum_k z^k/(k+j)!, by its series near 0."""
    exponential = cmath.exp(z)
    if abs(z) < 1.0:
        s = 0j
        for k in range(15, -1, -1):
            s = s * z / (k + 4) + 1.0
        s /= 6.0
        phi2 = 0.5 + z * s
        return exponential, 1.0 + z * phi2, phi2, 2.0 * s - phi2
    phi1 = (exponential - 1.0) / z
    phi2 = (phi1 - 1.0) / z
    return exponential, phi1, phi2, 2.0 * (phi2 - 0.5) / z - phi2


@unfused_jit
def step_table(angle: Array, zeta: float, dt: float, table: Array) -> None:
    """Exact response of every mode over dt: rows of table (TABLE_ROWS * modes,), x = (t - t_n)/dt.

    0..3: q and q' from (q, q'), as [[0, 1], [2, 3]]; 4, 5: q from the forces 1 - x and x; 6, 7: q' from these;
    8, 9: q and q' from the force x (x - 1). By the two roots of each mode.
    """
    n = angle.shape[0]
    for k in range(n):
        w2 = 4.0 * math.sin(0.5 * angle[k]) ** 2
        damping = zeta * w2
        square = damping * damping - w2
        least = ROOTS_APART * max(damping * damping, w2)
        if abs(square) < least:  # critical damping: the double root is split by 1e-4
            square = least if square > 0.0 else -least
        root1 = -damping - cmath.sqrt(complex(square, 0.0))
        root2 = w2 / root1
        e1, a1, b1, c1 = _phi(root1 * dt)
        e2, a2, b2, c2 = _phi(root2 * dt)
        g = 1.0 / (root2 - root1)
        table[k] = ((root2 * e1 - root1 * e2) * g).real
        table[n + k] = ((e2 - e1) * g).real
        table[2 * n + k] = -w2 * table[n + k]
        table[3 * n + k] = ((root2 * e2 - root1 * e1) * g).real
        table[5 * n + k] = dt * ((b2 - b1) * g).real
        table[4 * n + k] = dt * ((a2 - a1) * g).real - table[5 * n + k]
        table[7 * n + k] = dt * ((root2 * b2 - root1 * b1) * g).real
        table[6 * n + k] = dt * ((root2 * a2 - root1 * a1) * g).real - table[7 * n + k]
        table[8 * n + k] = dt * ((c2 - c1) * g).real
        table[9 * n + k] = dt * ((root2 * c2 - root1 * c1) * g).real


@unfused_jit
def doubled_table(table: Array, out: Array) -> None:
    """The table of a step twice as long: the first half's response carried through the second, plus the second's."""
    n = table.shape[0] // TABLE_ROWS
    for k in range(n):
        a, b, c, d = table[k], table[n + k], table[2 * n + k], table[3 * n + k]
        p0, p1, r0, r1 = table[4 * n + k], table[5 * n + k], table[6 * n + k], table[7 * n + k]
        p2, r2 = table[8 * n + k], table[9 * n + k]
        out[k], out[n + k] = a * a + b * c, b * (a + d)
        out[2 * n + k], out[3 * n + k] = c * (a + d), d * d + b * c
        # 1 - x on the whole step is 1 .. 1/2 on the first half and 1/2 .. 0 on the second; x the other way round.
        x, y = p0 + 0.5 * p1, r0 + 0.5 * r1
        out[4 * n + k] = a * x + b * y + 0.5 * p0
        out[6 * n + k] = c * x + d * y + 0.5 * r0
        x, y = 0.5 * p1, 0.5 * r1
        out[5 * n + k] = a * x + b * y + 0.5 * p0 + p1
        out[7 * n + k] = c * x + d * y + 0.5 * r0 + r1
        # x (x - 1) is a quarter of itself plus the line 0 .. -1/4 on the first half, -1/4 .. 0 on the second.
        x, y = 0.25 * (p2 - p1), 0.25 * (r2 - r1)
        out[8 * n + k] = a * x + b * y + 0.25 * (p2 - p0)
        out[9 * n + k] = c * x + d * y + 0.25 * (r2 - r0)
