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
EXPLICIT_LAW = Law(1.31e-09, -0.4298, 0.1388, 0.2361, 0.1886, 0, 225.1, 3.334e-05, 0)
IMPLICIT_LAW = Law(2.412e-10, -0.411, 0.1032, 0.08003, -0.1358, 231.8, 161.5, 0.0001003, 0)
AUTO_RK45_LAW = Law(2.307e-11, -0.1972, 0.06084, 0.5299, -0.1681, 8.808, 1e05, 0, 6.315e-12)
RK45_LAW = Law(6.629e-09, -0.1609, 0.1532, 0.2633, -0.1619, 0, 227, 0, 1.809e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    0.1206,
    1.3279,
    2.1224,
    1.4131,
    -2.0857,
    0.8532,
    -0.5198,
    0.1134,
    -0.9318,
    1.3609,
    -0.7738,
    1.1244,
    0.2427,
    -1.3485,
    0.4083,
    -2.2362,
    -0.2788,
    -0.0339,
    -0.8379,
    -0.1433,
    -0.0684,
)
IMPLICIT_MORE = (
    -1.8986,
    -1.7628,
    -1.6398,
    1.0609,
    1.3629,
    -0.2394,
    -0.8614,
    0.7331,
    1.7524,
    3.8638,
    2.3717,
    -0.2174,
    -3.1091,
    -1.6272,
    -0.5867,
    -0.9690,
    -0.7022,
    -0.5121,
    0.3925,
    -0.8295,
    -0.8153,
)
RK45_MORE = (
    -35.9772,
    -29.5473,
    -35.3684,
    48.1550,
    10.6423,
    16.6408,
    15.5790,
    -23.2429,
    20.0962,
    15.9985,
    4.8967,
    -11.6061,
    29.1151,
    2.4806,
    10.9342,
    -37.4732,
    -0.9509,
    -15.9539,
    -16.5874,
    0.9168,
    -1.2002,
    -5.6122,
)
