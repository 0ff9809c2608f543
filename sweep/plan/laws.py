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
EXPLICIT_LAW = Law(1.23e-09, -0.4333, 0.143, 0.2402, 0.1796, 2.466e-08, 225, 3.599e-05, 0)
IMPLICIT_LAW = Law(2.644e-10, -0.4089, 0.1175, 0.07938, -0.1362, 229.9, 146.6, 0.0001056, 0)
AUTO_RK45_LAW = Law(2.537e-11, -0.1486, 0.09713, 0.4462, -0.3404, 16.96, 1e05, 0, 5.931e-12)
RK45_LAW = Law(5.479e-09, -0.1672, 0.1252, 0.2623, -0.2031, 0, 188.1, 0, 1.867e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -2.0976,
    2.0551,
    -1.5897,
    1.8841,
    -0.5415,
    0.5211,
    -1.1810,
    0.4541,
    -1.1082,
    0.2386,
    -0.2861,
    -0.1182,
    0.6314,
    -0.3285,
    0.1518,
    -0.1367,
    -0.5432,
    -0.0490,
    -1.4321,
    0.3427,
    -0.1330,
)
IMPLICIT_MORE = (
    -2.9748,
    1.1594,
    -0.6338,
    -0.3356,
    0.7030,
    -0.6268,
    -0.5745,
    -2.7435,
    -0.3676,
    1.3319,
    -0.3098,
    0.4147,
    -1.4099,
    -0.1390,
    -0.1760,
    -0.2365,
    2.3350,
    0.0711,
    0.3401,
    0.4762,
    0.0037,
)
RK45_MORE = (
    -5.1894,
    -2.0811,
    -1.4145,
    2.7722,
    -0.5068,
    0.7758,
    1.5248,
    -1.7696,
    1.8990,
    0.6506,
    -0.0484,
    -0.0742,
    1.5623,
    -0.2094,
    0.2627,
    -0.6042,
    1.5067,
    -0.7490,
    -3.5918,
    0.0467,
    0.2496,
    -3.1745,
)
