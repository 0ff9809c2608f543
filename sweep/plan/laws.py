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
    -1.1605,
    3.4901,
    0.1608,
    1.9806,
    -0.2830,
    -0.4242,
    -1.8819,
    1.1824,
    -1.6896,
    0.2441,
    0.1356,
    0.5451,
    0.5662,
    -0.3600,
    -0.1976,
    -1.7111,
    -0.5449,
    0.1562,
    -0.5700,
    0.1809,
    -0.1556,
)
IMPLICIT_MORE = (
    -2.5908,
    -0.5825,
    -1.8689,
    0.3191,
    1.1050,
    -1.0890,
    1.4038,
    -1.0875,
    -0.2419,
    1.6291,
    0.7611,
    0.6369,
    -1.6200,
    -0.2279,
    -0.4188,
    0.3641,
    1.0371,
    -0.2160,
    0.4551,
    0.0126,
    -0.6425,
)
RK45_MORE = (
    -50.5306,
    -2.6236,
    2.5942,
    12.8696,
    14.8394,
    5.3606,
    36.0292,
    -6.4688,
    -12.4180,
    12.2925,
    -5.8439,
    5.3192,
    5.4545,
    3.3829,
    2.1352,
    -37.7563,
    -1.7457,
    -10.9752,
    -21.0863,
    3.1952,
    1.7247,
    -18.4943,
)
