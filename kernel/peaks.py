"""The largest kinetic energy of the middle site of one chain, by the method that the task and the accuracy ask for."""

from typing import NamedTuple

from kernel import rk45
from kernel.crests import new_crests
from kernel.jit import jit
from kernel.linear import linear_peak
from kernel.method import ATOL_OVER_RTOL, DORMAND_PRINCE, MODES, RK45, RTOL_SHARE, Integrator, methods_of
from kernel.model import T_END_OVER_N, Array, Chain
from kernel.splitting import splitting_peak

method_of = jit(methods_of)


class Peak(NamedTuple):
    """What one integration tells, in the units of kernel.model."""

    status: int  # kernel.status code
    method: int  # index into kernel.method.METHOD_WORDS
    KE: float  # largest kinetic energy of the middle site over continuous time, over TE
    t: float  # when
    steps: int
    evaluations: int  # of the chain's forces
    site_evaluations: int  # the same, counting only the sites that were integrated
    crests: Array  # (PARTS,): the same of each part of the run


@jit
def peak_of(chain: Chain, V: float, noise: float, integrator: Integrator) -> Peak:
    """Run one impact at speed V to t = 2.25 N.

    noise: size of random first velocities of the sites, over V; where dampers are strong they are left at rest.
    """
    N, accuracy, most = chain.N, integrator.accuracy, integrator.max_steps
    unit = 1.0 / (chain.impactor_mass * V * V)  # of KE over TE, per squared speed
    method = method_of(N, chain.zeta, chain.spring.is_linear(), integrator)
    if method == DORMAND_PRINCE:
        rtol, atol = integrator.rtol, integrator.atol
        if integrator.kind != RK45:
            rtol = RTOL_SHARE * accuracy
            whole = chain.impactor_mass / N * V  # the speed of a chain that has all the momentum
            atol = ATOL_OVER_RTOL * rtol * min(1.0, whole)
        r = rk45.integrate(chain, V, rtol, atol, most, T_END_OVER_N * N, False, False, noise)
        KE, crests = unit * r.peak_speed**2, unit * r.crests**2
        return Peak(r.status, method, KE, r.t_peak, r.steps, r.evaluations, r.site_evaluations, crests)
    speeds = new_crests()
    if method == MODES:
        x = linear_peak(chain, V, accuracy, most, speeds)
        KE, crests = unit * x.speed**2, unit * speeds**2
        return Peak(x.status, method, KE, x.t, x.steps, x.site_evaluations // N, x.site_evaluations, crests)
    s = splitting_peak(chain, V, method, accuracy, most, noise, False, speeds)
    KE, crests = unit * s.speed**2, unit * speeds**2
    return Peak(s.status, method, KE, s.t, s.steps, s.evaluations, s.site_evaluations, crests)
