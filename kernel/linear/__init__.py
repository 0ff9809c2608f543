"""The comparative linear chain: only its contact is nonlinear, so the chain itself is propagated exactly.

Two designs that share nothing but the modes' formulas. `sites` (weak damping): an exact banded two-step march in site
space with steps of one cell transit time. `modes` (stiff damping, and chains too short for the bands): exact modes,
high ones grouped. Everything is scaled to impact speed 1, since KE/TE depends on the speed through K sqrt(V) only.
"""

import math
from typing import NamedTuple

import numpy as np

from kernel.jit import jit
from kernel.linear import modes, sites
from kernel.linear.contact import Contact
from kernel.linear.peak import HALF, padded_samples, sampled_peak, scattered_peak
from kernel.linear.spectrum import chain_modes
from kernel.linear.tables import H, macro_tables
from kernel.model import T_END_OVER_N
from kernel.simd import flush_subnormals, restore_subnormals
from kernel.status import DONE, NOT_FINITE

# Measured validity of the march in site space: its polynomials of site 1 fail beyond these dampings, and the two ends
# must not see each other within a step.
SHORTEST, SITES_PER_ZETA = 11, 20
STIFF, STIFF_FINE, FINE = 0.8, 0.35, 0.99e-4  # largest zeta, and below accuracy FINE
TIGHTEST, LOOSEST = 1e-8, 1e-2  # accuracies beyond these are taken as these
# A run that blew up, or whose middle site has all the energy and by its error more, is done again, this much tighter.
RETRIES, TIGHTER = 3, 8.0


class LinearPeak(NamedTuple):
    """What one run tells, in the units of kernel.model."""

    status: int  # kernel.status code: DONE, NOT_FINITE, STEP_BUDGET
    speed: float  # max |v_mid| over continuous time in [0, 2.25 N]
    t: float  # when
    steps: int  # that resolve the contact, retries included
    site_evaluations: int  # steps of a site, or of a mode


@jit
def by_sites(N: int, zeta: float, mass: float, stiffness: float, accuracy: float, max_steps: int) -> LinearPeak:
    """The march in site space; mass: the impactor's in site masses, stiffness: K sqrt(V). Speeds per impact speed."""
    finer = 1e-3 / accuracy
    contact = Contact(stiffness, mass, zeta, 16.0 * finer**0.4, min(1.0, 0.25 * finer**0.15), min(H, 0.1 / finer**0.25))
    t_end = T_END_OVER_N * N
    last = math.ceil(t_end) + HALF // 2 + 2
    samples = np.zeros(padded_samples(2 * last + 1))
    status, steps, site_steps = sites.march(
        N, contact, macro_tables(zeta), t_end + 0.5 * HALF, samples, 2 * last + 1, max_steps
    )
    square, t = sampled_peak(samples, 2 * last + 1 - HALF, 0.5 * H, t_end)
    return LinearPeak(status, math.sqrt(square), t, steps, site_steps)


@jit
def by_modes(N: int, zeta_T: float, mass: float, stiffness: float, accuracy: float, max_steps: int) -> LinearPeak:
    """The march of the modes; arguments as by_sites."""
    coarser, zeta, t_end = accuracy / 1e-3, N * zeta_T, T_END_OVER_N * N
    impact = modes.Impact(
        stiffness,
        mass,
        0.01 * coarser ** (2.0 / 3.0),
        0.1 * coarser**0.3,
        64.0 * coarser ** (-1.0 / 3.0),
        0.1 * N,
    )
    chain = chain_modes(N, zeta, zeta_T)
    status, steps, count, times, speeds = modes.march(chain, zeta, impact, t_end, max_steps)
    square, t = scattered_peak(times, speeds, count, t_end)
    return LinearPeak(status, math.sqrt(square), t, steps, steps * chain.number)


@jit
def sites_serve(N: int, zeta: float, accuracy: float) -> bool:
    """Whether the march in site space is accurate for this chain."""
    return SHORTEST + int(SITES_PER_ZETA * zeta) <= N and zeta <= (STIFF if accuracy > FINE else STIFF_FINE)


@jit
def checked(status: int, KE_over_TE: float) -> int:
    """A site cannot have more than all the energy: a run that says so, or nan, blew up."""
    return NOT_FINITE if status == DONE and not KE_over_TE <= 1.0 + 1e-6 else status


@jit
def linear_peak(N: int, zeta_T: float, M: float, V: float, K: float, accuracy: float, max_steps: int) -> LinearPeak:
    """Peak speed of the middle site of the linear chain; M = m_im/m_T, V over c0, K as in kernel.model.Chain.

    accuracy: of the kinetic energy, 1e-2 .. 1e-8. A pure function of its arguments; M, V and K must be positive.
    """
    zeta, mass, stiffness = N * zeta_T, N * M, K * math.sqrt(V)
    if not math.isfinite(zeta + mass + stiffness + accuracy):
        return LinearPeak(NOT_FINITE, math.nan, math.nan, 0, 0)
    accuracy = min(max(accuracy, TIGHTEST), LOOSEST)
    word, tries, steps, sites = flush_subnormals(), 0, 0, 0
    while True:
        if sites_serve(N, zeta, accuracy):
            run = by_sites(N, zeta, mass, stiffness, accuracy, max_steps - steps)
        else:
            run = by_modes(N, zeta_T, mass, stiffness, accuracy, max_steps - steps)
        steps, sites, tries = steps + run.steps, sites + run.site_evaluations, tries + 1
        status = checked(run.status, run.speed * run.speed / mass)
        if status != NOT_FINITE or tries > RETRIES:
            break
        accuracy = max(accuracy / TIGHTER, TIGHTEST)
    restore_subnormals(word)
    return LinearPeak(status, run.speed * V, run.t, steps, sites)
