"""What the last state tells: where the energy went, and how many links have flipped."""

import math
from typing import Any, NamedTuple

from kernel.model import Chain
from kernel.varied import DAMPING, MASS, STIFFNESS, own


class Dissipated(NamedTuple):
    """Energy that the dampers have taken, over TE: what is missing at the end."""

    def unit(self) -> str:
        return "TE"

    def at_end(self, chain: Chain, view: Any, kept: float) -> float:
        damping = 0.0
        for i in range(1, chain.N + 1):
            damping += chain.zeta * own(chain.varied, DAMPING, i)
        if damping == 0.0:  # what is missing is the error of the integration
            return 0.0
        v0 = view.velocity(0)
        kinetic, strain = 0.5 * chain.impactor_mass * v0 * v0, chain.contact.energy_at(-view.gap())
        for i in range(1, chain.N + 1):
            v = view.velocity(i)
            kinetic += 0.5 * own(chain.varied, MASS, i) * v * v
            strain += own(chain.varied, STIFFNESS, i) * chain.spring.energy_at(view.strain(i))
        return max(0.0, kept - kinetic - strain)

    def scale(self, chain: Chain, V: float) -> float:
        return 0.5 * chain.impactor_mass * V * V

    def kept(self, chain: Chain, V: float) -> float:
        return 0.5 * chain.impactor_mass * V * V


class Stored(NamedTuple):
    """Energy in the springs at the end of the run, over TE."""

    def unit(self) -> str:
        return "TE"

    def at_end(self, chain: Chain, view: Any, kept: float) -> float:
        strain = 0.0
        for i in range(1, chain.N + 1):
            strain += own(chain.varied, STIFFNESS, i) * chain.spring.energy_at(view.strain(i))
        return strain

    def scale(self, chain: Chain, V: float) -> float:
        return 0.5 * chain.impactor_mass * V * V


class Rebound(NamedTuple):
    """Energy of the impactor at the end of the run, over TE."""

    def unit(self) -> str:
        return "TE"

    def needs_impactor(self) -> None:
        """The energy is the impactor's own."""

    def at_end(self, chain: Chain, view: Any, kept: float) -> float:
        v0 = view.velocity(0)
        return 0.5 * chain.impactor_mass * v0 * v0

    def scale(self, chain: Chain, V: float) -> float:
        return 0.5 * chain.impactor_mass * V * V


class Flipped(NamedTuple):
    """Share of the links beyond their barrier at the end of the run; nan where the law has none."""

    def unit(self) -> str:
        return "share of the links"

    def needs_barrier(self) -> None:
        """A link has flipped where it is beyond it."""

    def counts(self) -> None:
        """Whole links."""

    def at_end(self, chain: Chain, view: Any, kept: float) -> float:
        barrier = chain.spring.barrier()
        if math.isnan(barrier):
            return math.nan
        beyond = 0.0
        for i in range(1, chain.N + 1):
            e = view.strain(i)
            if own(chain.varied, STIFFNESS, i) > 0.0 and ((e < barrier) if barrier < 0.0 else (e > barrier)):
                beyond += 1.0
        return beyond

    def scale(self, chain: Chain, V: float) -> float:
        links = chain.N if own(chain.varied, STIFFNESS, chain.N) > 0.0 else chain.N - 1  # a free end has no last link
        return float(links)
