"""The cost model's coefficients: data, written by `python -m tests.calibrate --write`."""

from typing import NamedTuple


class Law(NamedTuple):
    """Seconds of both chains: (c a^p V^q M^r (0.01 + zeta)^s + stiff zeta) (N + impact) (N + sites) + start.

    zeta = N zeta_T; a: the splitting's accuracy, or rk45's rtol.
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


FITTED = ("EXPLICIT", "IMPLICIT", "RK45")

# Seconds of one core of the machine of the fit; sweep.plan.cost.seconds_per_work compares this machine.
EXPLICIT = Law(2.516e-09, -0.3161, 0.1645, 0.2825, 0.1087, 11.08, 128, 3.018e-05, 0)
IMPLICIT = Law(4.685e-10, -0.3857, 0.09672, 0.1944, -0.09174, 153.3, 153.3, 2.9e-05, 0)
RK45 = Law(7.115e-09, -0.1644, 0.1423, 0.2794, -0.2099, 6.849e-170, 133.3, 3.273e-25, 2.131e-08)
# The expected refinements of certified tasks, in runs of certify's probe: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -2.7386,
    0.2706,
    -3.2247,
    -0.6247,
    -0.8253,
    0.0428,
    -1.6601,
    -0.4163,
    -0.5290,
    0.5187,
    0.3172,
    -0.5690,
    -0.2937,
    -0.5086,
    0.2083,
    -0.4079,
    -0.5096,
    0.1341,
    -1.1798,
    0.2794,
    -0.0505,
    1.0353,
    0.0000,
)
IMPLICIT_MORE = (
    0.1090,
    -2.1071,
    -3.5362,
    -0.4760,
    1.4224,
    0.1035,
    -0.7395,
    -2.2863,
    -1.7821,
    2.0449,
    -0.2206,
    2.2399,
    -1.7143,
    -0.3780,
    0.4331,
    -0.7828,
    1.6392,
    0.5267,
    -0.3287,
    0.1830,
    -0.3910,
    0.0000,
    0.0000,
)
RK45_MORE = (
    -0.4783,
    -1.7605,
    -1.4376,
    0.7632,
    0.2895,
    0.1673,
    -1.1681,
    -1.3935,
    -0.4412,
    0.4819,
    0.0875,
    -0.2719,
    0.2458,
    -0.1712,
    0.0424,
    0.1732,
    -1.2108,
    -0.1049,
    -1.8157,
    -0.0029,
    0.0214,
    0.4816,
    -0.6977,
)
