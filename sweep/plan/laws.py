"""The cost model's coefficients: data, written by `python -m tests.calibrate --write`."""

from typing import NamedTuple


class Law(NamedTuple):
    """Seconds of both chains: (c a^p V^q M^r (0.01 + zeta)^s + stiff zeta) (N + impact) (N + sites) + start.

    zeta = N zeta_T; a: the splitting's accuracy, or rk45's rtol. MODERATE: "auto" where it takes rk45 for the bistable
    chain, with the splitting's accuracy.
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


FITTED = ("EXPLICIT", "IMPLICIT", "MODERATE", "RK45")

# Seconds of one core of the machine of the fit; sweep.plan.cost.seconds_per_work compares this machine.
EXPLICIT = Law(2.827e-09, -0.3659, 0.1303, 0.2308, 0.09795, 3.716e-07, 188.1, 3.598e-05, 0)
IMPLICIT = Law(3.535e-10, -0.3847, 0.1092, 0.125, -0.1183, 509.2, 87.67, 0.0001171, 0)
MODERATE = Law(0, -0.2155, 0.1016, 0.5146, -0.2707, 18.2, 8.796e278, 0, 0)
RK45 = Law(9.877e-09, -0.1571, 0.1522, 0.2831, -0.2062, 0, 209.5, 0, 2.505e-08)
# The expected refinements of certified tasks, in runs of certify's probe: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.3513,
    -0.7545,
    -0.7573,
    0.6709,
    0.3856,
    0.1490,
    -0.6404,
    -0.8479,
    -1.1982,
    -0.2231,
    -0.0965,
    -0.0616,
    -0.0339,
    -0.0572,
    -0.1393,
    -0.8011,
    -0.4607,
    -0.0176,
    -1.4116,
    0.2079,
    -0.2833,
    0.0000,
)
IMPLICIT_MORE = (
    -3.0085,
    0.3368,
    -2.6206,
    -0.8865,
    1.1034,
    0.6014,
    0.2386,
    -3.1046,
    0.0235,
    1.1331,
    -0.5440,
    1.9569,
    -1.6165,
    -0.5814,
    0.1823,
    0.6364,
    1.8452,
    1.0706,
    0.3966,
    0.4111,
    -0.5138,
    0.0000,
)
RK45_MORE = (
    0.4515,
    -1.0795,
    -0.2099,
    0.2029,
    1.1350,
    0.5152,
    -2.6826,
    -0.2608,
    -0.3411,
    -0.0663,
    -0.1622,
    -0.2650,
    -0.4788,
    -0.7826,
    0.3158,
    -1.2237,
    0.7245,
    -0.0796,
    -1.7732,
    0.9127,
    -0.0968,
    -2.7952,
)
