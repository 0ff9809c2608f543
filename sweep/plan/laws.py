"""The cost model's coefficients: data, written by `python -m tests.calibrate --write`."""

from typing import NamedTuple


class Law(NamedTuple):
    """Seconds of both chains: (c a^p V^q M^r (0.01 + zeta)^s + stiff zeta) (N + impact) (N + sites) + start.

    zeta = N zeta_T; a: the splitting's accuracy, or rk45's rtol. AUTO_RK45_LAW: "auto" where it takes Dormand-Prince
    for the bistable chain, with the splitting's accuracy.
    """

    c: float
    a: float
    V: float
    M: float
    damping: float
    impact: float  # the steps that resolve the impact, as long as the wave takes for this many sites
    sites: float  # a pass over N sites costs as much as N + this many sites' arithmetic
    start: float
    stiff: float = 0.0


FITTED = ("EXPLICIT", "IMPLICIT", "AUTO_RK45", "RK45")  # each _LAW below

# Seconds of one core of the machine of the fit; sweep.plan.speed compares this machine.
EXPLICIT_LAW = Law(2.738e-09, -0.3712, 0.1405, 0.2231, 0.1573, 0, 170.8, 2.906e-05, 0)
IMPLICIT_LAW = Law(2.432e-10, -0.4349, 0.1021, 0.1084, -0.1155, 150.7, 150.5, 9.447e-05, 0)
AUTO_RK45_LAW = Law(8.195e-11, -0.2061, 0.09616, 0.4807, -0.2921, 15.26, 1.889e04, 0, 2.622e-11)
RK45_LAW = Law(6.926e-09, -0.1582, 0.1399, 0.2594, -0.2113, 0, 173.4, 0, 1.906e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    0.0934,
    0.4593,
    -0.2481,
    0.9285,
    0.0905,
    0.1591,
    -0.9249,
    -0.1435,
    -1.1163,
    0.3073,
    0.0705,
    0.0972,
    0.1973,
    -0.2393,
    0.0449,
    -0.6979,
    -0.8930,
    -0.0623,
    -1.7638,
    -0.0253,
    -0.0757,
)
IMPLICIT_MORE = (
    -2.1427,
    -0.3902,
    -1.7118,
    -0.2731,
    1.1324,
    -0.5597,
    0.6997,
    -2.2361,
    -0.4994,
    0.8704,
    -0.1514,
    1.1850,
    -1.5875,
    -0.3128,
    0.5666,
    0.2614,
    1.1226,
    0.0673,
    0.2771,
    0.4266,
    -0.3348,
)
RK45_MORE = (
    0.4917,
    -2.0036,
    -0.4010,
    0.2125,
    -0.0858,
    0.5183,
    -2.9891,
    -1.1344,
    -1.4721,
    0.3926,
    0.1298,
    -0.1880,
    -0.4149,
    -0.2849,
    0.0359,
    -0.2872,
    0.2434,
    0.0059,
    -0.9177,
    0.0407,
    -0.0678,
    -2.0392,
)
