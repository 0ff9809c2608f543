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
EXPLICIT = Law(2.532e-09, -0.3166, 0.165, 0.2821, 0.1103, 11.35, 124.6, 2.915e-05, 0)
IMPLICIT = Law(4.773e-10, -0.3845, 0.09676, 0.1922, -0.09082, 152.1, 152.2, 2.639e-05, 0)
RK45 = Law(7.115e-09, -0.1644, 0.1423, 0.2794, -0.2099, 6.849e-170, 133.3, 3.273e-25, 2.131e-08)
# The expected refinements of certified tasks, in runs of certify's probe: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -2.7124,
    0.6915,
    -3.1243,
    -0.6263,
    -0.7051,
    -0.0959,
    -2.0088,
    -0.2050,
    -0.6121,
    0.4317,
    0.4810,
    -0.5141,
    -0.2689,
    -0.4309,
    0.2172,
    -0.4400,
    -0.3437,
    0.1303,
    -0.9292,
    0.2948,
    -0.0608,
    1.2343,
    0.0000,
)
IMPLICIT_MORE = (
    0.2507,
    -2.1260,
    -3.5768,
    -0.5053,
    1.3852,
    -0.0260,
    -0.6489,
    -2.0269,
    -1.7507,
    1.9417,
    -0.1234,
    2.1798,
    -1.7299,
    -0.3048,
    0.5120,
    -0.8663,
    1.6248,
    0.5935,
    -0.2182,
    0.1883,
    -0.3676,
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
