"""The peak speed of the middle site of one chain, by the integrator that the task and the accuracy ask for."""

from typing import NamedTuple

from kernel import rk45
from kernel.jit import jit, written_out
from kernel.linear import linear_peak
from kernel.method import ATOL_OVER_RTOL, RK45, Integrator
from kernel.model import T_END_OVER_N, chain_of
from kernel.splitting import bistable_peak
from kernel.splitting.rules import SWITCH

# Of the bistable chain: kernel.splitting's two, numbered as there, and rk45.
METHOD_WORDS = ("explicit", "implicit", "rk45")
BY_RK45 = 2
# Where dampers are implicit, Dormand-Prince is cheaper for n (N zeta_T)^MORE_DAMPED < SHORT accuracy^LOOSER with n = N,
# or LONG where the impact's own steps no longer count: measured on 166 tasks of 2 to 1000 sites, N zeta_T from 0.4 to
# 30, at four targets. With this share of the accuracy as its rtol it was within a third of the target; a looser one is
# no cheaper, as dampers bound its steps.
LONG, SHORT, MORE_DAMPED, LOOSER, RTOL_SHARE = 200, 1.27, 0.65, -0.42, 1.0 / 30.0


class Peak(NamedTuple):
    """What one integration tells, in the units of kernel.model."""

    status: int  # kernel.status code
    method: int  # index into METHOD_WORDS
    speed: float  # max |v_mid| over continuous time
    t: float  # when
    steps: int
    evaluations: int  # of the chain's forces
    site_evaluations: int  # the same, counting only the sites that were integrated


@jit
def rk45_serves(N: int, zeta: float, accuracy: float) -> bool:
    """Whether "auto" takes Dormand-Prince for a bistable chain of damping ratio zeta."""
    return zeta >= SWITCH and min(N, LONG) * zeta**MORE_DAMPED < SHORT * accuracy**LOOSER


@written_out
def peak_of_bistable(N: int, zeta_T: float, M: float, V: float, integrator: Integrator) -> Peak:
    """Run one impact of mass M = m_im/m_T at speed V on the bistable chain to t = 2.25 N."""
    chain, rtol, atol, by_rk45 = chain_of(N, zeta_T, M, True), integrator.rtol, integrator.atol, integrator.kind == RK45
    if not by_rk45 and rk45_serves(N, chain.zeta, integrator.accuracy):
        by_rk45, rtol = True, RTOL_SHARE * integrator.accuracy
        atol = ATOL_OVER_RTOL * rtol * min(1.0, M * V)  # M V: the speed of a chain that has all the momentum
    if by_rk45:
        r = rk45.integrate(chain, V, rtol, atol, integrator.max_steps, T_END_OVER_N * N)
        return Peak(r.status, BY_RK45, r.peak_speed, r.t_peak, r.steps, r.evaluations, r.site_evaluations)
    s = bistable_peak(N, zeta_T, M, V, chain.K, chain.c2, chain.c3, integrator.accuracy, integrator.max_steps, False)
    return Peak(s.status, s.method, s.speed, s.t, s.steps, s.evaluations, s.site_evaluations)


@written_out
def peak_of_linear(N: int, zeta_T: float, M: float, V: float, integrator: Integrator) -> Peak:
    """The same on the comparative linear chain."""
    chain = chain_of(N, zeta_T, M, False)
    if integrator.kind == RK45:
        r = rk45.integrate(chain, V, integrator.rtol, integrator.atol, integrator.max_steps, T_END_OVER_N * N)
        return Peak(r.status, BY_RK45, r.peak_speed, r.t_peak, r.steps, r.evaluations, r.site_evaluations)
    x = linear_peak(N, zeta_T, M, V, chain.K, integrator.accuracy, integrator.max_steps)
    return Peak(x.status, 0, x.speed, x.t, x.steps, x.site_evaluations // N, x.site_evaluations)
