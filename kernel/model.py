"""The physics: the chain and its energies; the laws of its springs and its contact stand in kernel.laws.

Source: paper sections 2 and 2.1 with one sign convention. Units: displacement in unit-cell lengths, time in cell
transit times, so velocity is in long-wave sound speeds, force in k_T L, energy (with unit site mass) in k_T L^2/N.

Site i = 1..N is at index i - 1 of the arrays of sites; the impactor (0) has numbers of its own, the wall (N+1) is at
rest. Link i joins sites i and i+1; its strain is e_i = u_{i+1} - u_i, negative in compression.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.jit import jit
from kernel.laws.bistable import Bistable
from kernel.laws.hertz import Hertz
from kernel.task import M0, T_END_OVER_N
from kernel.varied import DAMPING, LIGHTNESS, MASS, STIFFNESS, VARIED_ROWS, own

Array = NDArray[np.float64]

MIDDLE = 0.5  # of the chain: the site that is watched
ROUNDING = 1e-9  # of a number of sites
OTHER_DRAW = 16807  # begins the second draw of `disturb`, as 1 does the first; any other number does as well
PAPER_CONTACT = Hertz().compiled()
LINEAR = Bistable(0.0, 0.0)  # what every chain is compared with: all springs have unit stiffness at rest


class Chain(NamedTuple):
    """One chain with its impactor, in the dimensionless units above; what the compiled code integrates."""

    N: int  # number of sites
    zeta: float  # intersite damping ratio N zeta_T
    spring: Any  # a law of kernel.laws, of every link
    contact: Any  # a law of kernel.laws, of impactor and first site
    impactor_mass: float  # N M, in site masses
    t_end: float  # duration of a run
    site: int  # whose kinetic energy is watched
    force: float = 1.0  # what one unit of force is, in k_T L
    frequency: float = 1.0  # what one unit of frequency is, in inverse cell transit times
    varied: Any = None  # kernel.varied.Varied where the chain is not uniform


class Lattice(NamedTuple):
    """All that a kernel.Model says of a chain, whatever its length; what the compiled code makes chains of.

    Mass, stiffness and damping are numbers over those of the uniform chain. Such a chain is the uniform one in units
    of its own, which `lattice_chain` takes: the fast integrators know of unit masses and unit springs only. What
    differs from site to site is in `varied`, of chains of one length; the three numbers are 1 then.
    """

    spring: Any
    contact: Any  # in chain lengths
    t_end: float  # over N
    site: float  # which part of the chain lies before the site that is watched, and with it
    mass: float
    stiffness: float
    damping: float
    varied: Any = None
    until: float = math.inf  # over N: when a run ends that ends earlier; that of the linear chain does not


@jit
def frequency_of(lattice: Lattice) -> float:
    """What one unit of frequency is in the chain's own units, and one of speed, in those of the uniform chain."""
    return math.sqrt(lattice.stiffness / lattice.mass)


def time_of_sound(lattice: Lattice, N: int) -> float:
    """What sound takes to the watched site of a chain of N sites, in cell transit times over N."""
    if lattice.varied is None:
        return lattice.site / frequency_of(lattice)
    before = math.ceil(lattice.site * N - ROUNDING)
    lightness, stiffness = (
        lattice.varied.rows.reshape(VARIED_ROWS, -1)[row, :before] for row in (LIGHTNESS, STIFFNESS)
    )
    return float(np.sum(1.0 / np.sqrt(lightness * stiffness))) / N


@jit
def site_of(N: int, lattice: Lattice) -> int:
    """The number of the watched site of a chain of N sites."""
    return max(1, min(N, math.ceil(lattice.site * N - ROUNDING)))


@jit
def lattice_chain(N: int, zeta_T: float, M: float, lattice: Lattice) -> Chain:
    """A chain of this lattice, struck by M = m_im/m_T (not over M0)."""
    return _chain(N, zeta_T, M, lattice, lattice.spring, min(lattice.t_end, lattice.until))


@jit
def linear_chain(N: int, zeta_T: float, M: float, lattice: Lattice) -> Chain:
    """The linear chain that it is compared with."""
    return _chain(N, zeta_T, M, lattice, Bistable(0.0, 0.0), lattice.t_end)


@jit
def _chain(N: int, zeta_T: float, M: float, lattice: Lattice, spring: Any, t_end_over_N: float) -> Chain:
    frequency = frequency_of(lattice)
    zeta = N * zeta_T * lattice.damping / math.sqrt(lattice.stiffness * lattice.mass)
    contact = lattice.contact.of_cells(N).softened(lattice.stiffness)
    t_end = t_end_over_N * N * frequency
    site = site_of(N, lattice)
    mass, force = N * M / lattice.mass, lattice.stiffness
    return Chain(N, zeta, spring, contact, mass, t_end, site, force, frequency, lattice.varied)


@jit
def chain_of(N: int, zeta_T: float, M: float, spring: Any) -> Chain:
    """A chain of these springs, struck by M = m_im/m_T (not over M0), all else as in the paper."""
    lattice = Lattice(spring, PAPER_CONTACT, T_END_OVER_N, MIDDLE, 1.0, 1.0, 1.0, None, math.inf)
    return _chain(N, zeta_T, M, lattice, spring, T_END_OVER_N)


def make_chain(N: int, zeta_T: float, M_over_M0: float, *, bistable: bool) -> Chain:
    """The paper's chain of a task, or the linear one that it is compared with."""
    return chain_of(N, zeta_T, M_over_M0 * M0, Bistable() if bistable else LINEAR)


@jit
def tension(spring: Any, e: float) -> float:
    """Tension of a spring at strain e."""
    return e + spring.excess(e)


@jit
def energy(chain: Chain, u: Array, v: Array, u0: float, v0: float) -> float:
    """Total energy: kinetic, of the springs, and of the contact. u, v: sites, (N,) or longer; u0, v0: impactor."""
    N, varied = chain.N, chain.varied
    total = 0.5 * chain.impactor_mass * v0 * v0 + chain.contact.energy_at(u0 - u[0])
    for i in range(N):
        e = (u[i + 1] if i + 1 < N else 0.0) - u[i]
        stored = own(varied, STIFFNESS, i + 1) * chain.spring.energy_at(e)
        total += 0.5 * own(varied, MASS, i + 1) * v[i] * v[i] + stored
    return total


@jit
def dissipated_power(chain: Chain, v: Array) -> float:
    """Rate at which the dampers take energy, -dE/dt >= 0. v: sites, (N,) or longer."""
    N = chain.N
    total = own(chain.varied, DAMPING, N) * v[N - 1] * v[N - 1]
    for i in range(N - 1):
        slip = v[i + 1] - v[i]
        total += own(chain.varied, DAMPING, i + 1) * slip * slip
    return 2.0 * chain.zeta * total


@jit
def site_acceleration(chain: Chain, view: Any, i: int) -> float:
    """Acceleration of site i = 1..N + 1; the last is the wall."""
    if i > chain.N:
        return 0.0
    return (link_force(chain, view, i) - link_force(chain, view, i - 1)) * own(chain.varied, LIGHTNESS, i)


@jit
def link_rate(chain: Chain, view: Any, i: int) -> float:
    """The derivative of `link_force` by time, i = 0..N."""
    after = view.velocity(i + 1) if i < chain.N else 0.0
    slip = after - view.velocity(i)
    if i == 0:
        overlap = -view.gap()
        return chain.contact.stiffness_at(overlap) * slip if overlap > 0.0 else 0.0
    rate = own(chain.varied, STIFFNESS, i) * chain.spring.stiffness_at(view.strain(i)) * slip
    if chain.zeta > 0.0:
        eta = 2.0 * chain.zeta * own(chain.varied, DAMPING, i)
        rate += eta * (site_acceleration(chain, view, i + 1) - site_acceleration(chain, view, i))
    return rate


@jit
def link_force(chain: Chain, view: Any, i: int) -> float:
    """Tension of link i = 0..N, spring and damper; link 0 is the contact. view: as kernel.quantities.View."""
    if i == 0:
        return -chain.contact.push(-view.gap())
    after = view.velocity(i + 1) if i < chain.N else 0.0
    pull = own(chain.varied, STIFFNESS, i) * tension(chain.spring, view.strain(i))
    return pull + 2.0 * chain.zeta * own(chain.varied, DAMPING, i) * (after - view.velocity(i))


@jit
def disturb(v: Array, N: int, size: float) -> None:
    """Add random velocities, even from -size to size, to v[:N].

    There are two draws of them, for sizes above 0 and below, always the same: a run is compared with itself.
    """
    x = 1 if size > 0.0 else OTHER_DRAW
    for i in range(N):
        x = 48271 * x % 2147483647  # Park and Miller's generator
        v[i] += size * (2.0 * x / 2147483647.0 - 1.0)
