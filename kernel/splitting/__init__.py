"""Peak speed of the middle site by splitting methods: what is cheapest at moderate accuracy.

Light damping (zeta = N zeta_T < 0.4): an explicit fourth-order splitting (kernel.splitting.explicit). Strong damping: a
leapfrog with Crank-Nicolson dampers (kernel.splitting.implicit). Both are packed over the sites of one chain, so the
bits of a task depend on nothing but the task.
"""

import math
from typing import NamedTuple

from kernel.jit import jit
from kernel.model import Chain
from kernel.simd import flush_subnormals, restore_subnormals
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import SWITCH, explicit_rule, implicit_rule
from kernel.status import NOT_FINITE

EXPLICIT, IMPLICIT = range(2)
RETRIES = 3  # of a run that blew up
TIGHTER = 8.0  # accuracy of a run over that of its retry


class Outcome(NamedTuple):
    """What one task gives, in the units of kernel.model."""

    status: int  # kernel.status code
    method: int  # EXPLICIT or IMPLICIT
    speed: float  # max |v_mid| over continuous time in [0, 2.25 N]; nan where the run blew up every time
    t: float  # when
    steps: int  # of the whole chain and of the contact zone, retries included, as all counts
    evaluations: int  # of the chain's forces
    site_evaluations: int  # the same, counting only the sites that the wave had reached
    retries: int  # runs that blew up and were done again with smaller steps


@jit
def bistable_peak(
    N: int,
    zeta_T: float,
    M: float,
    V: float,
    K: float,
    c2: float,
    c3: float,
    accuracy: float,
    max_steps: int,
    all_sites: bool,
) -> Outcome:
    """One impact of mass M = m_im/m_T at speed V on a chain with contact stiffness K, spring law c2, c3.

    accuracy: wanted relative error of the peak energy; max_steps: of the chain and of the contact zone, retries
    included; all_sites: integrate also sites that the wave has not reached, which costs more and changes nothing.
    """
    chain = Chain(N, N * zeta_T, c2, c3, K, N * M)
    method = EXPLICIT if chain.zeta < SWITCH else IMPLICIT
    status, speed, t, retries, steps, evaluations, sites = NOT_FINITE, math.nan, math.nan, 0, 0, 0, 0
    word = flush_subnormals()
    while True:
        if method == EXPLICIT:
            run = run_explicit(chain, V, explicit_rule(chain.zeta, accuracy), max_steps - steps, all_sites)
        else:
            run = run_implicit(chain, V, implicit_rule(chain, V, accuracy), max_steps - steps)
        steps += run.steps + run.substeps
        evaluations += run.evaluations
        sites += run.site_evaluations
        if run.status != NOT_FINITE or retries == RETRIES:
            break
        retries += 1
        accuracy /= TIGHTER
    restore_subnormals(word)
    status = run.status
    if status != NOT_FINITE:
        speed, t = run.speed, run.t
    return Outcome(status, method, speed, t, steps, evaluations, sites, retries)
