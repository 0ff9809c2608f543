"""The peak speed of the middle site of one chain, by the integrator that the task and the accuracy ask for."""

from typing import NamedTuple

from kernel import rk45
from kernel.jit import jit
from kernel.method import Integrator
from kernel.model import T_END_OVER_N, chain_of

METHOD_WORDS = ("rk45",)


class Peak(NamedTuple):
    """What one integration tells, in the units of kernel.model."""

    status: int  # kernel.status code
    method: int  # index into METHOD_WORDS
    speed: float  # max |v_mid| over continuous time
    t: float  # when
    steps: int
    evaluations: int  # of the chain's forces
    site_evaluations: int  # the same, counting only the sites that the wave had reached


@jit
def peak_of(N: int, zeta_T: float, M: float, V: float, bistable: bool, integrator: Integrator) -> Peak:
    """Run one impact of mass M = m_im/m_T at speed V to t = 2.25 N."""
    chain = chain_of(N, zeta_T, M, bistable)
    run = rk45.integrate(chain, V, integrator.rtol, integrator.atol, integrator.max_steps, T_END_OVER_N * N)
    return Peak(run.status, 0, run.peak_speed, run.t_peak, run.steps, run.evaluations, run.site_evaluations)
