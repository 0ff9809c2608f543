"""The numbers that stand in the paper, with the place where each stands. Nothing here is computed by us."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SPEED_DRAWN = 1e-6  # of V: the tasks drawn around one of the paper differ so much, which no well-conditioned one feels


@dataclass(frozen=True)
class Point:
    """A ke_ratio that the paper gives with all its parameters."""

    key: str
    where: str
    N: int
    zeta_T: float
    M_over_M0: float
    V_over_V0: float
    paper: float
    rounding: tuple[float, float, float]  # half of the last digit given of zeta_T, M_over_M0, V_over_V0

    def ensemble(self, draws: int) -> "NDArray[np.float64]":
        """The task, then tasks (draws, 4) that the paper would print as the same numbers.

        They are spread over the digits that it does not print, and over SPEED_DRAWN of V.
        """
        steps = (0.8191725134, 0.6710436067, 0.5497004779)  # fills the cube evenly
        shares = np.modf(np.outer(np.arange(draws), steps))[0]
        shares = np.where(shares > 0.5, shares - 1, shares) * 2
        rounding = np.maximum(self.rounding, (0.0, 0.0, SPEED_DRAWN * self.V_over_V0))
        changed = np.array([self.zeta_T, self.M_over_M0, self.V_over_V0]) + shares * rounding
        return np.column_stack([np.full(draws, self.N), changed])


POINTS = (
    Point("fig. 4", "section 3, lowest of figure 4a", 191, 3.3e-5, 2, 2, 0.0130, (5e-7, 0, 0)),
    Point("fig. 5h", "section 3, lowest of figure 5h", 200, 4e-5, 0.936, 5.179, 0.0054, (0, 5e-4, 5e-4)),
    Point("fig. 5l", "section 3, lowest of figure 5l", 200, 4e-4, 0.553, 10, 0.0052, (0, 5e-4, 0)),
    Point("fig. 8", "section 3, lowest of figure 8a", 330, 2.585e-5, 0.1622, 10, 1.4e-3, (5e-9, 5e-5, 0)),
)


_4A, _5H, _5L, _8A = POINTS


@dataclass(frozen=True)
class Said:
    """Any other number; ours agrees within `factor`, by the paper's rounding or its "of the order of"."""

    key: str
    where: str
    what: str
    paper: float
    factor: float


SAID = {
    one.key: one
    for one in (
        Said("c2", "section 2.1", "quadratic spring coefficient c2", 5.2592, 1.00001),
        Said("c3", "section 2.1", "cubic spring coefficient c3", 6.7523, 1.00001),
        Said("eps0", "section 2.2", "strain of the first inflection of the energy", 0.13, 1.04),
        Said("eps2", "section 2.2", "strain of the second stable state", 0.46, 1.011),
        Said("M0", "section 2.2", "nominal impactor mass over the chain's, by its equation", 0.159, 1.0032),
        Said("min4", "figure 4a, text", "lowest ke_ratio of the map, wherever it is", _4A.paper, 1.1),
        Said("waves50", "figure 2d, text", "solitary waves in the train at N = 50", 1, 1.0),
        Said("threshold4d", "figure 4d, text", "N/zeta_T below which the bistable chain never loses", 1e3, 3.2),
        Said("undamped5", "figure 5a-d, text", "lowest ke_ratio without damping (0.1 to 0.01)", 0.0316, 3.2),
        Said("min5h", "figure 5h, text", "lowest ke_ratio of the panel, wherever it is", _5H.paper, 1.1),
        Said("M5h", "figure 5h, text", "M/M0 of that lowest ke_ratio", _5H.M_over_M0, 1.06),
        Said("V5h", "figure 5h, text", "V/V0 of that lowest ke_ratio", _5H.V_over_V0, 1.06),
        Said("min5l", "figure 5l, text", "lowest ke_ratio of the panel, wherever it is", _5L.paper, 1.1),
        Said("M5l", "figure 5l, text", "M/M0 of that lowest ke_ratio", _5L.M_over_M0, 1.06),
        Said("V5l", "figure 5l, text", "V/V0 of that lowest ke_ratio", _5L.V_over_V0, 1.06),
        Said("b22", "figure 6b, text", "exponent b of N_transition, (2, 2)", 0.3627, 1.02),
        Said("b24", "figure 6b, text", "exponent b of N_transition, (2, 4)", 0.4574, 1.02),
        Said("b0110", "figure 6b, text", "exponent b of N_transition, (0.1, 10)", 0.6212, 1.02),
        Said("t7a", "figure 7a, text", "t/N of the peak at the middle, (2, 1), N = 20", 1.4, 1.036),
        Said("min8", "figure 8a, text", "lowest ke_ratio of all impacts, wherever it is", _8A.paper, 1.1),
        Said("MV8", "section 5", "M V^2 over M0 V0^2 of the best impacts", 10, 2.0),
        Said("force9", "figure 9, text", "highest viscous force, fine bistable over the next (more than 2)", 2, 1.5),
        Said("PiIE0", "figure 13a, text", "Pi_IE of the best impact without damping", 1e-2, 3.2),
        Said("PiIE1", "figure 13b, text", "Pi_IE of the best impact at zeta_T = 4e-5", 1e-1, 3.2),
        Said("PiIE2", "figure 13c, text", "Pi_IE of the best impact at zeta_T = 4e-4", 1e-1, 3.2),
        Said("mass", "section 6", "best impactor's mass, % of the chain's", 1.59, 2.0),
        Said("speed", "section 6", "best impactor's speed, % of the sound speed", 260, 1.02),
    )
}
DOMAIN = {"N": (5, 500), "zeta_T": (1e-5, 1.0), "M_over_M0": (0.1, 10.0), "V_over_V0": (0.1, 10.0)}  # figures 4, 5
EXPONENTS = {(2.0, 2.0): 0.3627, (2.0, 4.0): 0.4574, (0.1, 10.0): 0.6212}  # b of N_transition ~ zeta_T^-b, figure 6b
# What the paper's words mean in numbers.
COARSE_N, FINE_N = 20, 200  # the abstract's two layers, "20 unit cells" and "200 unit cells"
LOW_DAMPING = (4e-5, 4e-4)  # the "low viscosities" of section 5 and figure 13
HIGH_DAMPING = 1e-2  # above it "the transition would no longer be evident" (section 3, on figure 4a)
MIN_POINTS = 3  # points that an order or a trend needs
ORDERED_SHARE = 0.75  # of all pairs in the claimed order: half-way between chance and always
MAJORITY = 0.5  # "most" is at least half
