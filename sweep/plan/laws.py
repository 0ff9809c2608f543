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
EXPLICIT_LAW = Law(2.773e-09, -0.3623, 0.1352, 0.2374, 0.101, 0, 195, 3.383e-05, 0)
IMPLICIT_LAW = Law(3.676e-10, -0.3956, 0.1008, 0.1386, -0.1224, 352.8, 103.2, 0.0001429, 0)
AUTO_RK45_LAW = Law(1.1e-10, -0.2305, 0.09657, 0.5134, -0.261, 12.2, 1.631e04, 0, 3.195e-11)
RK45_LAW = Law(7.969e-09, -0.1601, 0.1347, 0.2807, -0.2065, 0, 239.9, 0, 2.219e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.8365,
    -0.3589,
    -1.8022,
    0.5603,
    0.0602,
    0.1421,
    -0.9158,
    -0.5493,
    -1.2238,
    0.1882,
    -0.0480,
    -0.3784,
    0.0079,
    -0.1623,
    -0.1324,
    -0.7698,
    -0.3920,
    0.0109,
    -1.5007,
    0.2143,
    -0.2689,
)
IMPLICIT_MORE = (
    -3.2935,
    -0.1239,
    -3.8750,
    -0.0701,
    1.7771,
    0.0305,
    0.7376,
    -3.8811,
    0.2591,
    1.7104,
    -0.4909,
    2.7417,
    -2.6797,
    -0.7585,
    0.3166,
    -0.1904,
    2.3256,
    1.2390,
    0.5954,
    0.2518,
    -0.2183,
)
RK45_MORE = (
    0.9870,
    -1.3257,
    -0.6029,
    1.1245,
    -0.9957,
    1.0885,
    -1.8303,
    -0.8923,
    -1.8645,
    -0.2236,
    -0.1454,
    -0.2745,
    0.0411,
    -0.7302,
    0.1399,
    -0.5902,
    1.1504,
    -0.2830,
    -0.4568,
    0.2571,
    -0.0772,
    -4.0659,
)
