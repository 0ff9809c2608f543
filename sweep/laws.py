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
EXPLICIT = Law(1.649e-09, -0.3737, 0.1686, 0.3416, 0.1553, 208.8, 5.589e-05, 0)
IMPLICIT = Law(6.054e-11, -0.4949, 0.1498, 0.167, -0.1211, 1296, 0.000241, 0)
RK45 = Law(7.857e-09, -0.1495, 0.1613, 0.2877, -0.1565, 267.9, 1.077e-19, 1.686e-08)
# The expected extra of certified tasks, over their first run: exp(law @ sweep.cost.features).
EXPLICIT_EXTRA = (
    0.8548,
    0.4336,
    -0.3812,
    0.0756,
    0.0636,
    0.0556,
    -0.4965,
    -0.3901,
    -0.0048,
    0.0395,
    -0.0056,
    0.0413,
    -0.1548,
    -0.1175,
    0.0292,
    -0.4524,
    -0.1862,
    -0.0422,
    -1.1090,
    0.0839,
    0.0545,
)
IMPLICIT_EXTRA = (
    0.8548,
    0.4336,
    -0.3812,
    0.0756,
    0.0636,
    0.0556,
    -0.4965,
    -0.3901,
    -0.0048,
    0.0395,
    -0.0056,
    0.0413,
    -0.1548,
    -0.1175,
    0.0292,
    -0.4524,
    -0.1862,
    -0.0422,
    -1.1090,
    0.0839,
    0.0545,
)
RK45_EXTRA = (
    0.8548,
    0.4336,
    -0.3812,
    0.0756,
    0.0636,
    0.0556,
    -0.4965,
    -0.3901,
    -0.0048,
    0.0395,
    -0.0056,
    0.0413,
    -0.1548,
    -0.1175,
    0.0292,
    -0.4524,
    -0.1862,
    -0.0422,
    -1.1090,
    0.0839,
    0.0545,
)
