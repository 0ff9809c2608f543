"""The physics: constants, spring law, contact law, equations of motion, energies.

Source: paper sections 2 and 2.1 with one sign convention. Units: displacement in unit-cell lengths, time in cell
transit times, so velocity is in long-wave sound speeds, force in k_T L, energy (with unit site mass) in k_T L^2/N.

Site i = 1..N is at index i - 1 of the arrays of sites; the impactor (0) has numbers of its own, the wall (N+1) is at
rest. Link i joins sites i and i+1; its strain is e_i = u_{i+1} - u_i, negative in compression.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit

Array = NDArray[np.float64]

K_T = 225.7  # N/m, bulk stiffness, equal to c01
C02 = 1187.0  # N/m^2
C03 = 1524.0  # N/m^3
LENGTH = 1.0  # m
C_IMP = 2e9  # N/m^1.5, Hertz contact
C2 = C02 * LENGTH / K_T
C3 = C03 * LENGTH**2 / K_T
M0 = 0.159  # nominal impactor mass over total chain mass (the paper's rounded value)
V0 = 0.26  # nominal impact speed over the long-wave sound speed
T_END_OVER_N = 2.25  # every run covers the same physical time


class Chain(NamedTuple):
    """One chain with its impactor, in the dimensionless units above; what the compiled code integrates."""

    N: int  # number of sites
    zeta: float  # intersite damping ratio N zeta_T
    c2: float  # quadratic spring coefficient in compression (0 for the linear chain)
    c3: float  # cubic spring coefficient in compression (0 for the linear chain)
    K: float  # contact stiffness
    impactor_mass: float  # N M, in site masses


@jit
def chain_of(N: int, zeta_T: float, M: float, bistable: bool) -> Chain:
    """The bistable chain, or the linear chain it is compared with, struck by M = m_im/m_T (not over M0)."""
    c2, c3 = (C2, C3) if bistable else (0.0, 0.0)
    K = C_IMP * math.sqrt(LENGTH) / (K_T * N**1.5)
    return Chain(N, N * zeta_T, c2, c3, K, N * M)


def make_chain(N: int, zeta_T: float, M_over_M0: float, *, bistable: bool) -> Chain:
    """The same for a task's parameters."""
    return chain_of(N, zeta_T, M_over_M0 * M0, bistable)


@jit
def spring_force(c2: float, c3: float, e: float) -> float:
    """Tension of a spring at strain e; nonlinear in compression only."""
    m = e if e < 0.0 else 0.0
    return e + m * m * (c2 + c3 * m)


@jit
def spring_energy(c2: float, c3: float, e: float) -> float:
    """Integral of spring_force from 0 to e."""
    m = e if e < 0.0 else 0.0
    return 0.5 * e * e + m * m * m * (c2 / 3.0 + c3 / 4.0 * m)


@jit
def contact_force(K: float, overlap: float) -> float:
    """Hertz push between impactor and first site; zero when they are apart (overlap < 0)."""
    return K * overlap * math.sqrt(overlap) if overlap > 0.0 else 0.0


@jit
def contact_energy(K: float, overlap: float) -> float:
    """Integral of contact_force from 0 to overlap."""
    return 0.4 * K * overlap * overlap * math.sqrt(overlap) if overlap > 0.0 else 0.0


@jit
def energy(chain: Chain, u: Array, v: Array, u0: float, v0: float) -> float:
    """Total energy: kinetic, of the springs, and of the contact. u, v: sites, (N,) or longer; u0, v0: impactor."""
    N = chain.N
    total = 0.5 * chain.impactor_mass * v0 * v0 + contact_energy(chain.K, u0 - u[0])
    for i in range(N):
        e = (u[i + 1] if i + 1 < N else 0.0) - u[i]
        total += 0.5 * v[i] * v[i] + spring_energy(chain.c2, chain.c3, e)
    return total


@jit
def dissipated_power(chain: Chain, v: Array) -> float:
    """Rate at which the dampers take energy, -dE/dt >= 0. v: sites, (N,) or longer."""
    N = chain.N
    total = v[N - 1] * v[N - 1]
    for i in range(N - 1):
        slip = v[i + 1] - v[i]
        total += slip * slip
    return 2.0 * chain.zeta * total
