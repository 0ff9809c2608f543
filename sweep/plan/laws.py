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
IMPLICIT = Law(2.536e-10, -0.4228, 0.1017, 0.1156, -0.1156, 150.2, 150.2, 7.623e-05, 0)
MODERATE = Law(7.443e-11, -0.2305, 0.09657, 0.5134, -0.261, 12.2, 1.631e04, 0, 3.195e-11)
RK45 = Law(6.682e-09, -0.1608, 0.15, 0.2698, -0.2161, 0, 155.3, 0, 2e-08)
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
    0.0000,
)
IMPLICIT_MORE = (
    -1.8410,
    -1.3268,
    -1.9622,
    -0.0587,
    2.0266,
    1.7514,
    -0.6353,
    -1.8594,
    -0.1232,
    3.3748,
    -0.4587,
    1.8549,
    -1.9441,
    -1.6477,
    -0.0587,
    0.0870,
    0.0339,
    0.4416,
    -0.2094,
    0.7281,
    -1.1325,
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
    -1.1220,
)
