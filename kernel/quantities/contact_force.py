"""The push between impactor and chain."""

from typing import Any, NamedTuple

from kernel.model import Chain, link_force, link_rate


class ContactForce(NamedTuple):
    """Largest push of the impactor on the chain."""

    def unit(self) -> str:
        return "k_T L"

    def needs_impactor(self) -> None:
        """Nobody else pushes."""

    def value(self, chain: Chain, view: Any) -> float:
        return -link_force(chain, view, 0)

    def slope(self, chain: Chain, view: Any) -> float:
        return -link_rate(chain, view, 0)

    def scale(self, chain: Chain, V: float) -> float:
        return 1.0 / chain.force

    def is_push(self) -> None:
        """Integrators which resolve the contact within a step tell it from there."""
