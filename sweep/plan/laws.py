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
EXPLICIT_LAW = Law(1.232e-09, -0.4129, 0.1473, 0.258, 0.1315, 1.246e-11, 183.3, 4.235e-05, 0)
IMPLICIT_LAW = Law(1.867e-10, -0.439, 0.09015, 0.08785, -0.1348, 197.6, 248.8, 7.169e-05, 0)
AUTO_RK45_LAW = Law(1.821e-10, -0.2338, 0.07893, 0.5611, -0.2339, 10.49, 9253, 0, 7.471e-11)
RK45_LAW = Law(6.097e-09, -0.1683, 0.1367, 0.26, -0.1916, 0, 191.2, 0, 2.051e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.1392,
    1.8011,
    1.1165,
    2.4903,
    -0.0088,
    -0.7170,
    -0.8429,
    0.3362,
    -1.8724,
    0.4687,
    0.1397,
    0.7894,
    0.9391,
    -0.1746,
    -0.3288,
    -1.9585,
    -0.1583,
    0.1949,
    -1.1485,
    0.2520,
    -0.1497,
)
IMPLICIT_MORE = (
    -2.6556,
    -0.7477,
    -1.0852,
    0.4577,
    1.4276,
    -1.0331,
    1.2455,
    -1.9070,
    -0.9023,
    1.7610,
    0.8897,
    -0.4015,
    -3.0022,
    -0.2451,
    -0.2348,
    0.3211,
    1.0201,
    -0.2012,
    0.2938,
    0.2425,
    -0.5197,
)
RK45_MORE = (
    -1.4429,
    -3.8546,
    -1.3567,
    0.9316,
    1.0248,
    0.7448,
    -1.1230,
    -1.8879,
    -0.9446,
    0.6622,
    0.4663,
    -0.1873,
    0.4840,
    0.1118,
    0.0983,
    -1.1467,
    -0.9789,
    0.0823,
    -0.5040,
    0.0405,
    -0.0132,
    -2.3002,
)
