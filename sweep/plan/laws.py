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
EXPLICIT_LAW = Law(1.224e-09, -0.4341, 0.1397, 0.2392, 0.1866, 0, 227.6, 3.482e-05, 0)
IMPLICIT_LAW = Law(2.412e-10, -0.411, 0.1032, 0.08003, -0.1358, 231.8, 161.5, 0.0001003, 0)
AUTO_RK45_LAW = Law(2.41e-11, -0.15, 0.09652, 0.4411, -0.3281, 16.66, 1e05, 0, 5.834e-12)
RK45_LAW = Law(5.506e-09, -0.1674, 0.1316, 0.2596, -0.2059, 0, 174.4, 0, 1.855e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.8609,
    1.2746,
    -0.1848,
    1.5384,
    -0.4669,
    0.4081,
    -0.9886,
    0.2021,
    -1.4819,
    0.3108,
    -0.0500,
    0.2675,
    0.5195,
    -0.2854,
    0.1300,
    -0.6183,
    -0.3484,
    0.2079,
    -1.1865,
    0.4093,
    -0.1508,
)
IMPLICIT_MORE = (
    -1.9409,
    -0.2720,
    -1.4640,
    0.0641,
    0.9626,
    -0.8253,
    -0.2711,
    -2.8409,
    -1.0311,
    1.7930,
    -0.3974,
    0.6589,
    -2.2085,
    0.2895,
    -0.9181,
    -0.9478,
    2.0359,
    -0.2012,
    -0.4956,
    1.2661,
    -0.1750,
)
RK45_MORE = (
    -6.5107,
    -5.4233,
    -2.7249,
    4.0492,
    3.2385,
    0.9923,
    2.0468,
    -3.7742,
    4.2431,
    -0.0877,
    -0.1070,
    -0.4518,
    2.4773,
    0.9380,
    0.5560,
    -2.0565,
    2.7559,
    -1.0944,
    -5.0721,
    0.6816,
    0.1673,
    -2.3914,
)
