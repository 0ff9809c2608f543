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
EXPLICIT = Law(2.997e-09, -0.3049, 0.1702, 0.2771, 0.1084, 10.38, 131.7, 3.889e-05, 0)
IMPLICIT = Law(4.072e-10, -0.3605, 0.1013, 0.1178, -0.1518, 175.5, 175.1, 6.862e-05, 0)
MODERATE = Law(9.794e-10, -0.2276, 0.08171, 0.5284, -0.2718, 13.13, 1183, 4.554e-20, 4.401e-10)
RK45 = Law(6.682e-09, -0.1608, 0.15, 0.2698, -0.2161, 0, 155.3, 3.754e-25, 2e-08)
# The expected refinements of certified tasks, in runs of certify's probe: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -3.4802,
    0.1449,
    -3.7006,
    -0.8539,
    -1.1741,
    -0.0120,
    -1.5840,
    -0.4407,
    -0.5868,
    0.4127,
    0.2553,
    -0.6996,
    -0.3717,
    -0.6246,
    0.1698,
    -0.4068,
    -0.3472,
    0.1097,
    -1.0780,
    0.3357,
    0.0070,
    1.3673,
    0.0000,
)
IMPLICIT_MORE = (
    -2.9658,
    -2.1459,
    -1.4858,
    0.2322,
    4.0268,
    1.0269,
    -0.0483,
    -2.5576,
    -0.4672,
    4.0308,
    0.0264,
    2.0887,
    -1.8347,
    -2.4864,
    -0.2281,
    0.5454,
    0.1525,
    0.2154,
    -1.0560,
    -0.1671,
    -0.4654,
    0.0000,
    0.0000,
)
RK45_MORE = (
    -0.4599,
    -1.7323,
    -1.5141,
    0.6787,
    -0.1940,
    0.2743,
    -0.9762,
    -1.3975,
    -0.2922,
    0.5874,
    0.0391,
    -0.3157,
    0.1934,
    -0.4156,
    0.0527,
    0.2084,
    -1.1349,
    -0.1325,
    -1.8055,
    0.0057,
    0.0143,
    0.8318,
    -1.1220,
)
