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
EXPLICIT_LAW = Law(1.271e-09, -0.433, 0.1303, 0.2341, 0.185, 1.312e-08, 239.1, 3.913e-05, 0)
IMPLICIT_LAW = Law(2.636e-10, -0.4164, 0.0994, 0.0799, -0.1401, 264.9, 143.2, 0.000118, 0)
AUTO_RK45_LAW = Law(2.93e-10, -0.1838, 0.08864, 0.4533, -0.3076, 12.62, 7595, 0, 1.515e-10)
RK45_LAW = Law(7.108e-09, -0.1675, 0.1545, 0.2548, -0.1777, 0, 162.2, 0, 2.127e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -1.0495,
    1.6393,
    -0.1514,
    2.1882,
    -0.7294,
    0.6305,
    -0.7544,
    0.1959,
    -1.9396,
    0.4718,
    -0.0961,
    0.3282,
    0.8860,
    -0.3717,
    0.2652,
    -0.3371,
    -0.1154,
    0.2550,
    -1.5634,
    0.5677,
    -0.2133,
)
IMPLICIT_MORE = (
    -3.1621,
    -1.1742,
    -2.2555,
    -0.6884,
    1.3812,
    -0.6359,
    0.8199,
    -0.4877,
    -0.5813,
    1.6553,
    0.1041,
    0.6898,
    -1.0358,
    -0.7441,
    -0.4618,
    -0.2544,
    1.3223,
    -0.1145,
    0.8223,
    0.0852,
    0.0541,
)
RK45_MORE = (
    -45.0113,
    -28.5890,
    -8.7479,
    35.1549,
    3.9443,
    14.6026,
    33.3980,
    -18.4403,
    11.6354,
    -5.4333,
    -2.7607,
    2.3597,
    19.0637,
    -2.0080,
    5.6654,
    -11.6801,
    21.0698,
    -8.3053,
    -40.3279,
    4.6792,
    0.9301,
    -33.7391,
)
