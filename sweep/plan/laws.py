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
EXPLICIT_LAW = Law(1.177e-09, -0.4359, 0.1365, 0.2409, 0.1825, 0, 237.1, 3.75e-05, 0)
IMPLICIT_LAW = Law(2.174e-10, -0.4246, 0.09435, 0.07183, -0.144, 231.6, 201.1, 8e-05, 0)
AUTO_RK45_LAW = Law(9.048e-12, -0.2595, 0.07074, 0.505, -0.269, 16.43, 1e05, 0, 4.891e-12)
RK45_LAW = Law(6.265e-09, -0.1714, 0.1568, 0.2425, -0.181, 0, 165.3, 0, 2.07e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.8780,
    1.4303,
    -0.2228,
    1.8469,
    -0.7536,
    0.6310,
    -0.7797,
    0.1464,
    -1.6899,
    0.5000,
    -0.0870,
    0.2762,
    0.7089,
    -0.3721,
    0.2444,
    -0.3878,
    -0.0858,
    0.1698,
    -1.4529,
    0.4977,
    -0.2302,
)
IMPLICIT_MORE = (
    -3.5184,
    -1.6716,
    -3.4765,
    -0.7121,
    1.4215,
    -0.6430,
    0.6430,
    -1.4172,
    -1.6377,
    2.3814,
    0.3766,
    1.0222,
    -3.1898,
    -1.1214,
    -0.1624,
    -0.8740,
    0.6223,
    -0.7652,
    1.5940,
    -0.3023,
    0.0384,
)
RK45_MORE = (
    -36.3703,
    -25.6775,
    -18.4430,
    47.2518,
    27.9934,
    16.0961,
    25.2853,
    -15.6574,
    15.2229,
    15.9721,
    -0.7753,
    -2.4481,
    23.9567,
    8.7462,
    6.9551,
    -20.7527,
    -6.3187,
    -11.8914,
    -33.6602,
    0.2444,
    -0.1530,
    -23.4859,
)
