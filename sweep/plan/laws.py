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
EXPLICIT_LAW = Law(3.827e-09, -0.3664, 0.136, 0.2097, 0.08076, 1.417e-08, 113, 4.191e-05, 0)
IMPLICIT_LAW = Law(4.548e-10, -0.4074, 0.1201, 0.1125, -0.1149, 133.7, 133.7, 0.0001367, 0)
AUTO_RK45_LAW = Law(2.273e-11, -0.2207, 0.1091, 0.4612, -0.2974, 13.53, 9.999e04, 0, 7.895e-12)
RK45_LAW = Law(1.628e-08, -0.1597, 0.1543, 0.2768, -0.2025, 0, 113.5, 0, 4.298e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.9349,
    -0.5332,
    -1.8225,
    0.3674,
    -0.2619,
    0.0156,
    -1.0106,
    -0.6304,
    -1.2802,
    0.2483,
    0.1452,
    -0.3786,
    -0.0702,
    -0.3504,
    -0.0996,
    -0.6071,
    -0.4026,
    0.0798,
    -1.3705,
    0.1360,
    -0.1727,
)
IMPLICIT_MORE = (
    -3.8895,
    -0.2215,
    -3.4034,
    0.7808,
    2.7173,
    -0.7026,
    1.9880,
    -5.9854,
    -1.5852,
    3.4747,
    -0.2088,
    2.6612,
    -4.8024,
    -0.7457,
    0.8807,
    -1.9241,
    3.3187,
    1.3831,
    0.2637,
    0.2140,
    -0.3288,
)
RK45_MORE = (
    -2.9448,
    -0.3375,
    -0.7513,
    1.1089,
    -1.1115,
    0.1285,
    -0.7617,
    -0.9505,
    -1.7579,
    0.5310,
    -0.2384,
    -0.1472,
    -0.0879,
    -0.6119,
    0.1559,
    -1.8696,
    -0.9561,
    -0.0241,
    -1.2079,
    -0.2116,
    0.1061,
    -0.0923,
)
