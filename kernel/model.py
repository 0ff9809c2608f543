"""The physics: the chain and its energies; the laws of its springs and its contact stand in kernel.laws.

Source: paper sections 2 and 2.1 with one sign convention. Units: displacement in unit-cell lengths, time in cell
transit times, so velocity is in long-wave sound speeds, force in k_T L, energy (with unit site mass) in k_T L^2/N.

Site i = 1..N is at index i - 1 of the arrays of sites; the impactor (0) has numbers of its own, the wall (N+1) is at
rest. Link i joins sites i and i+1; its strain is e_i = u_{i+1} - u_i, negative in compression.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.laws.bistable import Bistable
from kernel.laws.hertz import hertz_of

Array = NDArray[np.float64]

M0 = 0.159  # nominal impactor mass over total chain mass (the paper's rounded value)
V0 = 0.26  # nominal impact speed over the long-wave sound speed
T_END_OVER_N = 2.25  # every run covers the same physical time


class Chain(NamedTuple):
    """One chain with its impactor, in the dimensionless units above; what the compiled code integrates."""

    N: int  # number of sites
    zeta: float  # intersite damping ratio N zeta_T
    spring: Any  # a law of kernel.laws, of every link
    contact: Any  # a law of kernel.laws, of impactor and first site
    impactor_mass: float  # N M, in site masses


@jit
def chain_of(N: int, zeta_T: float, M: float, spring: Any) -> Chain:
    """A chain of these springs, struck by M = m_im/m_T (not over M0) with the paper's contact."""
    return Chain(N, N * zeta_T, spring, hertz_of(N), N * M)


def make_chain(N: int, zeta_T: float, M_over_M0: float, *, bistable: bool) -> Chain:
    """The paper's chain of a task, or the linear one that it is compared with."""
    return chain_of(N, zeta_T, M_over_M0 * M0, Bistable() if bistable else Bistable().companion())


@jit
def tension(spring: Any, e: float) -> float:
    """Of a spring at strain e."""
    return e + spring.excess(e)


@jit
def energy(chain: Chain, u: Array, v: Array, u0: float, v0: float) -> float:
    """Total energy: kinetic, of the springs, and of the contact. u, v: sites, (N,) or longer; u0, v0: impactor."""
    N = chain.N
    total = 0.5 * chain.impactor_mass * v0 * v0 + chain.contact.energy_at(u0 - u[0])
    for i in range(N):
        e = (u[i + 1] if i + 1 < N else 0.0) - u[i]
        total += 0.5 * v[i] * v[i] + chain.spring.energy_at(e)
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


@jit
def link_force(chain: Chain, view: Any, i: int) -> float:
    """Tension of link i = 0..N, spring and damper; link 0 is the contact. view: as kernel.quantities.View."""
    if i == 0:
        return -chain.contact.push(-view.gap())
    after = view.velocity(i + 1) if i < chain.N else 0.0
    return tension(chain.spring, view.strain(i)) + 2.0 * chain.zeta * (after - view.velocity(i))


@jit
def disturb(v: Array, N: int, size: float) -> None:
    """Add random velocities, even from -size to size and always the same, to v[:N]: a run is compared with itself."""
    x = 1
    for i in range(N):
        x = 48271 * x % 2147483647  # Park and Miller's generator
        v[i] += size * (2.0 * x / 2147483647.0 - 1.0)
