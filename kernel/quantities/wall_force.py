"""The push of the chain on the wall, spring and damper."""

from typing import Any, NamedTuple

from kernel.model import Chain, link_force


class WallForce(NamedTuple):
    """Largest magnitude of the force of link N."""

    def unit(self) -> str:
        return "k_T L"

    def value(self, chain: Chain, view: Any) -> float:
        return -link_force(chain, view, chain.N)

    def slope(self, chain: Chain, view: Any) -> float:
        N, v = chain.N, view.velocity(chain.N)
        a = link_force(chain, view, N) - link_force(chain, view, N - 1)
        return chain.spring.stiffness_at(view.strain(N)) * v + 2.0 * chain.zeta * a

    def scale(self, chain: Chain, V: float) -> float:
        return 1.0
