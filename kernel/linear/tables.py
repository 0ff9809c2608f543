"""Tables of one macro step of the exact chain propagator; they depend on zeta only.

A mode of the damped chain with frequency w obeys q'' + 2 a q' + w^2 q = 0 with a = zeta w^2. Its two roots r1, r2 have
the sum -2 a, so q(t+H) = (e^{r1 H} + e^{r2 H}) q(t) - e^{-2 a H} q(t-H) exactly. Both factors are functions of
w^2 = 2 - 2 cos(angle), hence for all sites at once u(t+H) = T u(t) - D u(t-H) with T and D functions of the lattice
Laplacian: short symmetric stencils.

The contact force enters by its moments I_j = int F x^j dt, x = (t - t_n)/H: the response to a force is smooth over a
step, hence a polynomial in x whose coefficients are found from equally spaced nodes.

Units of kernel.model, displacements and forces per impact speed.
"""

import math
from typing import NamedTuple

import numpy as np

from kernel.jit import unfused_jit
from kernel.linear.interpolation import monomials
from kernel.model import Array
from kernel.simd import WIDTH

H = 1.0  # macro step; 1/2 and 1/4 gave the same accuracy at more cost
GHOSTS = 18  # mirrored sites kept on each side of the chain: no stencil reaches farther
ANGLES = 32  # quadrature over the wave numbers, exact for stencils shorter than that
MOMENTS = 9  # of the contact force in a macro step
TERMS = 10  # monomials of the free motion of site 1 within a macro step
TERMS_PADDED = 2 * WIDTH
NEAR_PADDED = 3 * WIDTH  # room for the GHOSTS sites near the struck end that a force reaches within a step
ROW_HALF = 10  # half-width of the rows that tell u_mid half a step back
ROW = 3 * WIDTH  # their length, 2 ROW_HALF + 1, in whole packs
DROPPED = 1e-8  # stencil coefficients below this are left out


MOMENTS_FROM_NODES = monomials(0, MOMENTS - 1, MOMENTS - 1)
NODES_TO_MOMENTS = np.ascontiguousarray(MOMENTS_FROM_NODES.T)
TERMS_FROM_NODES = monomials(0, TERMS - 1, TERMS - 1)
# A stencil coefficient is the mean over wave numbers of (its function) * cos(j angle): (ANGLES, GHOSTS + 1).
COSINES = np.cos(np.outer((np.arange(ANGLES) + 0.5) * np.pi / ANGLES, np.arange(GHOSTS + 1))) / ANGLES
# The same for a unit source at site 1 beside the free end, where the mirrored source adds: sites 1..GHOSTS.
SOURCE = np.ascontiguousarray(COSINES[:, :GHOSTS] + COSINES[:, 1:])


class Tables(NamedTuple):
    """What one macro step needs. Flat arrays with rows in whole packs, zeros behind what counts."""

    now: Array  # (GHOSTS + 1,): T from its centre outwards
    before: Array  # (GHOSTS + 1,): D
    half_now: int  # half-width of T
    half_before: int  # half-width of D
    near: int  # sites from the struck end that force and free motion of site 1 involve
    middle_now: Array  # (ROW,): weights of u_n, centred at the middle, in u_mid(t_n - H/2)
    middle_before: Array  # (ROW,): the same of u_{n-1}
    response: Array  # MOMENTS x NEAR_PADDED: moments of this step in the displacements at its end
    response_before: Array  # the same of the step before
    free: Array  # (2 near + MOMENTS) x TERMS_PADDED: from (u_n, u_{n-1} near the end, last moments) to monomials


class _Spectra(NamedTuple):
    """Functions of the wave number that the tables are averages of."""

    stencils: Array  # (4, ANGLES): T, D, middle_now, middle_before
    response: Array  # (MOMENTS, ANGLES): u(t_{n+1}) after a unit impulse at each node of this step
    response_before: Array  # the same, a node of the step before, as not told by u_n and u_{n-1}
    free_now: Array  # (TERMS, ANGLES): u at each node of the step per u_n
    free_before: Array  # the same per u_{n-1}
    free_force: Array  # (TERMS, MOMENTS): u_1 at each node per unit impulse at the nodes of the step before


@unfused_jit
def mode_responses(zeta: float, w2: float, dt: float, displacement: Array, velocity: Array) -> None:
    """Displacement of a mode (square frequency w2) at k*dt after a unit displacement and after a unit velocity."""
    damping = zeta * w2
    square = w2 - damping * damping
    cosine, sine = 1.0, dt  # near critical damping
    if square > 1e-12:
        w = math.sqrt(square)
        cosine, sine = math.cos(w * dt), math.sin(w * dt) / w
    elif square < -1e-12:
        w = math.sqrt(-square)
        cosine, sine = math.cosh(w * dt), math.sinh(w * dt) / w
    decay = math.exp(-damping * dt)
    b = decay * sine
    a = decay * cosine + damping * b
    displacement[0], velocity[0] = 1.0, 0.0
    for k in range(1, displacement.shape[0]):
        x, y = displacement[k - 1], velocity[k - 1]
        displacement[k] = a * x - w2 * b * y
        velocity[k] = b * x + (a - 2.0 * damping * b) * y


@unfused_jit
def _spectra(zeta: float) -> _Spectra:
    """All functions at all quadrature angles. Nodes at multiples of H/8 for the force, of H/9 for the free motion."""
    s = _Spectra(
        np.empty((4, ANGLES)),
        np.empty((MOMENTS, ANGLES)),
        np.empty((MOMENTS, ANGLES)),
        np.empty((TERMS, ANGLES)),
        np.empty((TERMS, ANGLES)),
        np.zeros((TERMS, MOMENTS)),
    )
    fine, fine_v = np.empty(2 * MOMENTS - 1), np.empty(2 * MOMENTS - 1)  # every second one a node; H/2 in the centre
    u, v = np.empty(TERMS), np.empty(TERMS)
    for q in range(ANGLES):
        w2 = 2.0 - 2.0 * ANGLES * COSINES[q, 1]
        damping = zeta * w2
        mode_responses(zeta, w2, H / (2 * MOMENTS - 2), fine, fine_v)
        mode_responses(zeta, w2, H / (TERMS - 1), u, v)
        v_end = v[TERMS - 1]
        velocity_end = u[TERMS - 1] - 2.0 * damping * v_end  # after a unit velocity
        whole = math.exp(-2.0 * damping * H)
        half = fine_v[MOMENTS - 1] / v_end
        s.stencils[0, q], s.stencils[1, q] = u[TERMS - 1] + velocity_end, whole
        s.stencils[2, q], s.stencils[3, q] = half, half * math.exp(-damping * H)
        for node in range(MOMENTS):
            # A velocity v at s inside the last step displaces u_n as well: what is left over is a source of its own.
            left = fine_v[2 * node] * math.exp(-2.0 * damping * H * (1.0 - node / (MOMENTS - 1)))
            s.response[node, q] = fine_v[2 * (MOMENTS - 1 - node)]
            s.response_before[node, q] = left
            share = SOURCE[q, 0] * left / v_end
            for i in range(TERMS):
                s.free_force[i, node] += share * v[i]
        share, share_before = velocity_end / v_end, -whole / v_end
        for i in range(TERMS):
            s.free_now[i, q] = u[i] + share * v[i]
            s.free_before[i, q] = share_before * v[i]
    return s


@unfused_jit
def _product(a: Array, b: Array, columns: int) -> Array:
    """First columns of the matrix product; numba's own would need scipy where the sweep runs."""
    out = np.zeros((a.shape[0], columns))
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            for j in range(columns):
                out[i, j] += a[i, k] * b[k, j]
    return out


@unfused_jit
def half_width(stencil: Array) -> int:
    """Place of the last coefficient that counts."""
    half = 0
    for j in range(1, GHOSTS + 1):
        if abs(stencil[j]) > DROPPED:
            half = j
    return half


@unfused_jit
def shortened(stencil: Array, half: int) -> Array:
    """Drop the coefficients beyond `half`, keeping the sum and the second moment.

    So rigid motion and the long-wave speed stay exact: without that the result was off by 1e-4.
    """
    out = stencil.copy()
    total, second = 0.0, 0.0
    for j in range(half + 1, GHOSTS + 1):
        total += 2.0 * out[j]
        second += 2.0 * out[j] * j * j
        out[j] = 0.0
    if half > 0:
        out[1] += 0.5 * second
        out[0] += total - second
    return out


@unfused_jit
def _padded(table: Array) -> Array:
    """The table (MOMENTS, near) flat, its rows padded by zeros to NEAR_PADDED."""
    out = np.zeros(MOMENTS * NEAR_PADDED)
    for i in range(MOMENTS):
        for j in range(table.shape[1]):
            out[i * NEAR_PADDED + j] = table[i, j]
    return out


@unfused_jit
def _put_columns(out: Array, row: int, table: Array) -> None:
    """Make the columns of the table (TERMS, any) the rows of `out` from `row` on."""
    for i in range(table.shape[1]):
        for j in range(TERMS):
            out[(row + i) * TERMS_PADDED + j] = table[j, i]


@unfused_jit
def _middle_row(half_row: Array) -> Array:
    """Both sides of a stencil given from its centre outwards, (ROW,)."""
    out = np.zeros(ROW)
    for j in range(ROW_HALF + 1):
        out[ROW_HALF - j] = out[ROW_HALF + j] = half_row[j]
    return out


@unfused_jit
def macro_tables(zeta: float) -> Tables:
    """Average the spectra over the wave numbers, from nodes to moments and monomials."""
    s = _spectra(zeta)
    stencils = _product(s.stencils, COSINES, GHOSTS + 1)
    half_now, half_before = half_width(stencils[0]), half_width(stencils[1])
    near = min(max(half_now, half_before) + 2, GHOSTS)
    free = np.zeros((2 * near + MOMENTS) * TERMS_PADDED)
    _put_columns(free, 0, _product(TERMS_FROM_NODES, _product(s.free_now, SOURCE, near), near))
    _put_columns(free, near, _product(TERMS_FROM_NODES, _product(s.free_before, SOURCE, near), near))
    by_node = _product(TERMS_FROM_NODES, s.free_force, MOMENTS)
    _put_columns(free, 2 * near, _product(by_node, NODES_TO_MOMENTS, MOMENTS))
    return Tables(
        shortened(stencils[0], half_now),
        shortened(stencils[1], half_before),
        half_now,
        half_before,
        near,
        _middle_row(stencils[2]),
        _middle_row(stencils[3]),
        _padded(_product(MOMENTS_FROM_NODES, _product(s.response, SOURCE, near), near)),
        _padded(_product(MOMENTS_FROM_NODES, _product(s.response_before, SOURCE, near), near)),
        free,
    )
