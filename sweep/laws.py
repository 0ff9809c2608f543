"""The cost model's coefficients: data, written by `python -m tests.calibrate --write`."""

from typing import NamedTuple


class Law(NamedTuple):
    """Seconds of both chains = (c a^p V^q M^r (0.01 + zeta)^s + stiff zeta) N (N + sites) + start, zeta = N zeta_T.

    a: the splitting's accuracy, or rk45's rtol.
    """

    c: float
    a: float
    V: float
    M: float
    damping: float
    sites: float  # a pass over N sites costs as much as N + this many sites' arithmetic
    start: float
    stiff: float = 0.0


FITTED = ("EXPLICIT", "IMPLICIT", "RK45")

# Seconds of one core of the machine of the fit; sweep.cost.seconds_per_work compares this machine.
EXPLICIT = Law(1.81e-09, -0.368, 0.1729, 0.3394, 0.1471, 193.4, 6.189e-05, 0)
IMPLICIT = Law(7.393e-11, -0.5082, 0.1243, 0.1634, -0.1326, 909.9, 0.0002865, 0)
RK45 = Law(7.848e-09, -0.15, 0.1677, 0.2822, -0.1491, 268.3, 7.691e-20, 1.543e-08)
# The expected extra of certified tasks, over their first run: exp(law @ sweep.cost.features).
EXPLICIT_EXTRA = (
    -1.4885,
    0.0873,
    -2.8652,
    -0.0101,
    -0.2070,
    0.1933,
    -0.4787,
    -0.3282,
    -0.1702,
    0.2965,
    0.0780,
    -0.6363,
    -0.1716,
    -0.1475,
    0.0953,
    -0.3233,
    -0.7919,
    0.0011,
    -2.1553,
    0.1282,
    -0.0289,
)
IMPLICIT_EXTRA = (
    -0.0124,
    -0.0539,
    -0.8059,
    0.0113,
    -0.0180,
    -0.0234,
    -0.8053,
    0.2192,
    0.3236,
    0.1621,
    0.1463,
    0.2568,
    -0.2712,
    -0.0782,
    0.0124,
    -0.1175,
    0.5566,
    -0.0619,
    0.9728,
    -0.0955,
    -0.0761,
)
RK45_EXTRA = (
    0.6775,
    0.5070,
    -0.3318,
    -0.0854,
    -0.3712,
    -0.2429,
    -1.2735,
    -0.6235,
    -0.5118,
    -0.4015,
    -0.3844,
    -0.0802,
    -0.2244,
    -0.2088,
    -0.0924,
    -0.4695,
    -0.5649,
    -0.0955,
    -1.1563,
    0.1600,
    0.1959,
)
