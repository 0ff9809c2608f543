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

SINGLE_MODES = 6.0  # over sqrt(zeta_T): the middle cannot feel single modes beyond
GROUP_RATIO = 1.7  # of the last to the first mode of a group
ROWS = 10  # of a step table, see step_table


class Modes(NamedTuple):
    """Modes and groups of them, then modes without weight up to whole packs."""

    angle: Array
    first: Array  # weight of a mode in the displacement of site 1
    middle: Array  # weight in the velocity of the middle site
    number: int  # that have a weight


@unfused_jit
def gauss_rule(n: int, points: int, node: Array, weight: Array) -> None:
    """Gauss nodes (from the centre) and weights, (points,), of a sum over n consecutive integers; points < n.

    The orthogonal polynomials are those of Gram: their recurrence has b_j^2 = j^2 (n^2 - j^2)/(16 j^2 - 4), and nodes
    are eigenvalues, weights n times the squared first components of eigenvectors, of the tridiagonal matrix with b off
    the diagonal (Golub and Welsch 1969). Implicit QL, only the first components being kept;
    numba's own eigenvalues would need scipy where the sweep runs. Nodes ascend.
    """
    off = np.zeros(points)
    for j in range(1, points):
        off[j - 1] = math.sqrt(j * j * (n * n - j * j) / (16.0 * j * j - 4.0))
    node[:], weight[:] = 0.0, 0.0
    weight[0] = 1.0
    for low in range(points):
        for _ in range(60):
            m = low
            while m < points - 1 and abs(off[m]) > 1e-16 * (abs(node[m]) + abs(node[m + 1])) + 1e-17 * n:
                m += 1
            if m == low:
                break
            shift = (node[low + 1] - node[low]) / (2.0 * off[low])
            shift = node[m] - node[low] + off[low] / (shift + math.copysign(math.hypot(shift, 1.0), shift))
            s, c, p = 1.0, 1.0, 0.0
            for i in range(m - 1, low - 1, -1):
                f, b = s * off[i], c * off[i]
                r = math.hypot(f, shift)
                off[i + 1] = r
                s, c = f / r, shift / r
                shift = node[i + 1] - p
                r = (node[i] - shift) * s + 2.0 * c * b
                p = s * r
                node[i + 1] = shift + p
                shift = c * r - b
                f = weight[i + 1]
                weight[i + 1] = s * weight[i] + c * f
                weight[i] = c * weight[i] - s * f
            node[low] -= p
            off[low], off[m] = shift, 0.0
    for i in range(points):
        for j in range(i + 1, points):
            if node[j] < node[i]:
                node[i], node[j], weight[i], weight[j] = node[j], node[i], weight[j], weight[i]
        weight[i] *= n * weight[i]


@unfused_jit
def _grouped(N: int, zeta: float, keep: int, place: Array, size: Array) -> int:
    """Places and sizes of single modes up to `keep`, and of the nodes that stand for all others; how many."""
    for k in range(keep):
        place[k], size[k] = k + 1.0, 1.0
    count, k = keep, keep + 1
    while k <= N:
        modes = min(int((GROUP_RATIO - 1.0) * k) + 1, N - k + 1)
        # Over a group the response varies the more, the less damped its modes are; nodes per variation as measured.
        phase = 9.0 * (GROUP_RATIO - 1.0) * (2 * N + 1) / (zeta * (2 * k - 1) * math.pi)
        points = min(modes, int(min(0.7 * phase, 1e6)) + 9)
        if 1.2 * points >= modes:
            points = modes
            for i in range(modes):
                place[count + i], size[count + i] = k + i, 1.0
        else:
            gauss_rule(modes, points, place[count : count + points], size[count : count + points])
            for i in range(count, count + points):
                place[i] += k + 0.5 * (modes - 1)
        count += points
        k += modes
    return count


@unfused_jit
def chain_modes(N: int, zeta: float, mid: int) -> Modes:
    """Single modes up to SINGLE_MODES sqrt(N/zeta), above them Gauss groups: exact for the sum over modes at site 1.

    The middle feels the grouped modes by their static compliance only, N+1-mid in all, which the first of them carries.
    """
    keep = N if zeta <= 0.0 else int(min(float(N), SINGLE_MODES * math.sqrt(N / zeta) + 8.0))
    place, size = np.empty(N), np.empty(N)
    count = _grouped(N, zeta, keep, place, size)
    padded = (count + WIDTH - 1) // WIDTH * WIDTH
    modes = Modes(np.full(padded, 1.0), np.zeros(padded), np.zeros(padded), count)
    norm, compliance = 4.0 / (2 * N + 1), 0.0
    for k in range(count):
        angle = (2.0 * place[k] - 1.0) * math.pi / (2 * N + 1)
        modes.angle[k] = angle
        modes.first[k] = norm * math.cos(0.5 * angle) ** 2 * size[k]
        if k < keep:
            modes.middle[k] = norm * math.cos(0.5 * angle) * math.cos((mid - 0.5) * angle)
            compliance += modes.middle[k] / (2.0 - 2.0 * math.cos(angle))
        elif k == keep:
            modes.middle[k] = (N + 1.0 - mid - compliance) * (2.0 - 2.0 * math.cos(angle))
    return modes


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
    """Exact response of every mode over dt: rows of table (ROWS * modes,), x = (t - t_n)/dt.

    0..3: q and q' from (q, q'), as [[0, 1], [2, 3]]; 4, 5: q from the forces 1 - x and x; 6, 7: q' from these;
    8, 9: q and q' from the force x (x - 1). By the two roots of each mode.
    """
    n = angle.shape[0]
    for k in range(n):
        w2 = 4.0 * math.sin(0.5 * angle[k]) ** 2
        damping = zeta * w2
        square = damping * damping - w2
        least = 1e-8 * max(damping * damping, w2)
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
    n = table.shape[0] // ROWS
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
