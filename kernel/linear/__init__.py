"""The comparative linear chain where the dampers are strong: only its contact is nonlinear, so its modes are exact.

High modes are grouped. Everything is scaled to impact speed 1, as KE/TE depends on the speed through the contact only.
"""

import math

from kernel.jit import jit
from kernel.linear import modes
from kernel.linear.spectrum import chain_modes
from kernel.model import Array, Chain
from kernel.run import Run
from kernel.status import DONE, NOT_FINITE

TIGHTEST, LOOSEST = 1e-8, 1e-2  # accuracies beyond these are taken as these
ROUNDING = 1e-6  # of the initial energy


@jit
def run_modes(chain: Chain, V: float, accuracy: float, max_steps: int, crests: Array) -> Run:
    """One impact at speed V on a linear chain; the law of its springs does not count.

    accuracy: of the kinetic energy, 1e-2 .. 1e-8; crests: as of kernel.watch.Watch; quantities are not looked at, as
    only the watched site and the contact are known.
    Right at any damping, but its steps and its modes are few only where the dampers are strong.
    """
    contact, t_end = chain.contact.at_unit_speed(V), chain.t_end
    if not math.isfinite(chain.zeta + chain.impactor_mass + contact.push(1.0) + accuracy):
        return Run(NOT_FINITE, math.nan, math.nan, 0, 0, 0, math.nan, 0)
    coarser = min(max(accuracy, TIGHTEST), LOOSEST) / 1e-3
    impact = modes.Impact(
        contact,
        chain.impactor_mass,
        0.01 * coarser**0.9,
        0.1 * coarser**0.4,
        64.0 * coarser**-0.45,
        0.1 * chain.N,
    )
    exact = chain_modes(chain.N, chain.zeta, chain.site)
    status, steps, speed, t = modes.march(exact, chain.zeta, impact, t_end, max_steps, crests)
    crests *= V
    sites = steps * exact.number
    if status == DONE and not speed * speed / chain.impactor_mass <= 1.0 + ROUNDING:  # more energy than there was
        status = NOT_FINITE
    return Run(status, speed * V, t, steps, sites // chain.N, sites, math.nan, 0)
