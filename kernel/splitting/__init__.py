"""Peak speed of the middle site by splitting methods: what is cheapest at moderate accuracy.

For light damping an explicit fourth-order splitting (kernel.splitting.explicit), for strong damping a leapfrog with
Crank-Nicolson dampers (kernel.splitting.implicit); kernel.method says where. The linear chain is the one with c2 = c3 =
0. Both are packed over the sites of one chain, so the bits of a task depend on nothing but the task.
"""

import math
from typing import NamedTuple

from kernel.jit import jit
from kernel.method import EXPLICIT, RETRIES, RETRY_TIGHTER
from kernel.model import Array, Chain
from kernel.simd import flush_subnormals, restore_subnormals
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import explicit_rule, implicit_rule
from kernel.status import NOT_FINITE


class Outcome(NamedTuple):
    """What one task gives, in the units of kernel.model."""

    status: int  # kernel.status code
    speed: float  # max |v_mid| over continuous time in [0, 2.25 N]; nan where the run blew up every time
    t: float  # when
    steps: int  # of the whole chain and of the contact zone, retries included, as all counts
    evaluations: int  # of the chain's forces
    site_evaluations: int  # the same, counting only the sites that the wave had reached
    retries: int  # runs that blew up and were done again with smaller steps


@jit
def splitting_peak(
    chain: Chain, V: float, method: int, accuracy: float, max_steps: int, noise: float, all_sites: bool, crests: Array
) -> Outcome:
    """One impact at speed V by a `method` of kernel.method, EXPLICIT or IMPLICIT.

    accuracy: wanted relative error of the peak energy; max_steps: of the chain and of the contact zone, retries
    included; noise: size of random first velocities, over V; all_sites: integrate also sites that the wave has not
    reached, which costs more and changes nothing (both of EXPLICIT only: IMPLICIT starts at rest and takes all sites);
    crests (PARTS,): receives the largest |v_mid| of each part of the run.
    """
    status, speed, t, retries, steps, evaluations, sites = NOT_FINITE, math.nan, math.nan, 0, 0, 0, 0
    word = flush_subnormals()
    while True:
        crests[:] = 0.0
        if method == EXPLICIT:
            run = run_explicit(
                chain, V, explicit_rule(chain.zeta, accuracy), max_steps - steps, noise, all_sites, crests
            )
        else:
            run = run_implicit(chain, V, implicit_rule(chain, V, accuracy), max_steps - steps, crests)
        steps += run.steps + run.substeps
        evaluations += run.evaluations
        sites += run.site_evaluations
        if run.status != NOT_FINITE or retries == RETRIES:
            break
        retries += 1
        accuracy /= RETRY_TIGHTER
    restore_subnormals(word)
    status = run.status
    if status != NOT_FINITE:
        speed, t = run.speed, run.t
    return Outcome(status, speed, t, steps, evaluations, sites, retries)
