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
EXPLICIT = Law(3.197e-09, -0.3352, 0.1668, 0.3149, 0.1674, 9.177, 128.7, 3.848e-05, 0)
IMPLICIT = Law(5.642e-10, -0.3662, 0.1038, 0.1969, -0.09074, 158.5, 158.5, 1.738e-05, 0)
RK45 = Law(5.896e-09, -0.1659, 0.1376, 0.2783, -0.2097, 6.154e-10, 246.5, 2.527e-25, 2.009e-08)
# The expected refinements of certified tasks, in runs of certify's probe: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -3.0513,
    1.3321,
    -3.9229,
    -0.7993,
    -0.2375,
    -0.3940,
    -1.4650,
    0.1333,
    -0.6908,
    0.1257,
    0.2763,
    -0.7309,
    -0.3542,
    -0.2196,
    0.0161,
    -0.5379,
    -0.0972,
    0.1779,
    -1.3731,
    -0.0153,
    -0.0138,
    0.6164,
    0.0000,
)
IMPLICIT_MORE = (
    -0.1113,
    -1.6553,
    -3.3480,
    -0.1491,
    1.1312,
    0.1177,
    -1.0712,
    -2.1833,
    -1.4361,
    2.0117,
    -0.1661,
    2.1542,
    -1.1627,
    -0.7211,
    0.1171,
    0.0695,
    1.3815,
    -0.0647,
    0.0593,
    0.0522,
    -0.1601,
    0.0000,
    0.0000,
)
RK45_MORE = (
    -0.6905,
    -0.3624,
    -2.6745,
    0.2833,
    2.4411,
    0.6665,
    -0.5090,
    -0.6740,
    -0.3919,
    -0.2346,
    -0.0487,
    -0.5169,
    0.0608,
    0.8216,
    0.1812,
    -0.1022,
    -1.2936,
    0.0136,
    -2.2272,
    -0.0969,
    -0.0010,
    0.0244,
    -1.6219,
)
