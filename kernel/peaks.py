"""The peak speed of the middle site of one chain, by the integrator that the task and the accuracy ask for."""

from typing import NamedTuple

from kernel import rk45
from kernel.jit import written_out
from kernel.linear import linear_peak
from kernel.method import RK45, Integrator
from kernel.model import T_END_OVER_N, chain_of
from kernel.splitting import bistable_peak

# Of the bistable chain: kernel.splitting's two, numbered as there, and rk45.
METHOD_WORDS = ("explicit", "implicit", "rk45")
BY_RK45 = 2


class Peak(NamedTuple):
    """What one integration tells, in the units of kernel.model."""

    status: int  # kernel.status code
    method: int  # index into METHOD_WORDS
    speed: float  # max |v_mid| over continuous time
    t: float  # when
    steps: int
    evaluations: int  # of the chain's forces
    site_evaluations: int  # the same, counting only the sites that were integrated


@written_out
def peak_of(N: int, zeta_T: float, M: float, V: float, bistable: bool, integrator: Integrator) -> Peak:
    """Run one impact of mass M = m_im/m_T at speed V to t = 2.25 N."""
    chain, accuracy, most = chain_of(N, zeta_T, M, bistable), integrator.accuracy, integrator.max_steps
    if integrator.kind == RK45:
        r = rk45.integrate(chain, V, integrator.rtol, integrator.atol, most, T_END_OVER_N * N)
        return Peak(r.status, BY_RK45, r.peak_speed, r.t_peak, r.steps, r.evaluations, r.site_evaluations)
    if bistable:
        s = bistable_peak(N, zeta_T, M, V, chain.K, chain.c2, chain.c3, accuracy, most, False)
        return Peak(s.status, s.method, s.speed, s.t, s.steps, s.evaluations, s.site_evaluations)
    x = linear_peak(N, zeta_T, M, V, chain.K, accuracy, most)
    return Peak(x.status, 0, x.speed, x.t, x.steps, x.site_evaluations // N, x.site_evaluations)
