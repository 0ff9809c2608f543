"""What happens to the site that is watched: its acceleration, and when the wave comes to it."""

import math
from typing import Any, NamedTuple

from kernel.maxima import cubic_crest
from kernel.model import Array, Chain, link_rate, site_acceleration
from kernel.varied import LIGHTNESS, own
from kernel.watch import FOUND, KEPT, SLOPE, VALUE, WHEN

ARRIVED = 0.01  # of the impact speed: from this speed on the wave counts as arrived
BISECTIONS = 40


class Acceleration(NamedTuple):
    """Largest magnitude of the acceleration of the site."""

    def unit(self) -> str:
        return "k_T L / m_T"

    def needs_free_site(self) -> None:
        """A driver that holds the site dictates it."""

    def value(self, chain: Chain, view: Any) -> float:
        return site_acceleration(chain, view, chain.site)

    def slope(self, chain: Chain, view: Any) -> float:
        change = link_rate(chain, view, chain.site) - link_rate(chain, view, chain.site - 1)
        return change * own(chain.varied, LIGHTNESS, chain.site)

    def scale(self, chain: Chain, V: float) -> float:
        return 1.0 / (chain.N * chain.frequency * chain.frequency)


class Arrival(NamedTuple):
    """When the site's speed first exceeds a hundredth of the impact speed, over N; nan where it never does.

    Of a driver in a scene the impact speed is its largest.
    """

    def unit(self) -> str:
        return "sqrt(m_T / k_T)"

    def needs_impactor(self) -> None:
        """The speed that counts is a part of the impact's."""

    def value(self, chain: Chain, view: Any) -> float:
        return view.velocity(chain.site)

    def slope(self, chain: Chain, view: Any) -> float:
        return site_acceleration(chain, view, chain.site)

    def kept(self, chain: Chain, V: float) -> float:
        return ARRIVED * V

    def is_known(self, memory: Array) -> bool:
        return bool(memory[WHEN] != 0.0)

    def fold(self, memory: Array, t: float, h: float, now: float, rate: float) -> None:
        memory[FOUND] = math.nan
        crest, high = cubic_crest(h, memory[VALUE], now, memory[SLOPE], rate)
        if crest > memory[KEPT]:  # the speed may be below again at the step's end
            # The cubic through the values and slopes at the step's ends, with the sign of its crest.
            v, p1, rise, p_end = memory[VALUE], h * memory[SLOPE], now - memory[VALUE], h * rate
            p2, p3 = 3.0 * rise - 2.0 * p1 - p_end, p1 + p_end - 2.0 * rise
            side, low = math.copysign(1.0, v + high * (p1 + high * (p2 + high * p3))), 0.0
            for _ in range(BISECTIONS):
                x = 0.5 * (low + high)
                if side * (v + x * (p1 + x * (p2 + x * p3))) > memory[KEPT]:
                    high = x
                else:
                    low = x
            memory[FOUND] = memory[WHEN] = t + high * h

    def scale(self, chain: Chain, V: float) -> float:
        return chain.N * chain.frequency
