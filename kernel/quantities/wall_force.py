"""The push of the chain on the wall, spring and damper: its largest magnitude, and its integral over time."""

from typing import Any, NamedTuple

from kernel.model import Array, Chain, link_force, link_rate
from kernel.watch import FOUND, SLOPE, VALUE, WHEN


class WallForce(NamedTuple):
    """Largest magnitude of the force of link N."""

    def unit(self) -> str:
        return "k_T L"

    def value(self, chain: Chain, view: Any) -> float:
        return -link_force(chain, view, chain.N)

    def slope(self, chain: Chain, view: Any) -> float:
        return -link_rate(chain, view, chain.N)

    def scale(self, chain: Chain, V: float) -> float:
        return 1.0 / chain.force


class Impulse(NamedTuple):
    """The integral of the force of link N over the run, over the impactor's momentum at first."""

    def unit(self) -> str:
        return "m_im V"

    def needs_impactor(self) -> None:
        """It is told over the impactor's momentum."""

    def value(self, chain: Chain, view: Any) -> float:
        return -link_force(chain, view, chain.N)

    def slope(self, chain: Chain, view: Any) -> float:
        return -link_rate(chain, view, chain.N)

    def fold(self, memory: Array, t: float, h: float, now: float, rate: float) -> None:
        # Of the cubic through the values and slopes at the step's ends.
        memory[FOUND] += h * (0.5 * (memory[VALUE] + now) + h / 12.0 * (memory[SLOPE] - rate))
        memory[WHEN] = t + h

    def scale(self, chain: Chain, V: float) -> float:
        return chain.impactor_mass * V
