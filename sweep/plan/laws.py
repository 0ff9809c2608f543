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
EXPLICIT_LAW = Law(1.201e-09, -0.4323, 0.137, 0.2408, 0.1664, 0, 232.7, 4.029e-05, 0)
IMPLICIT_LAW = Law(2.906e-10, -0.4127, 0.09752, 0.09, -0.1305, 209.3, 102.4, 9.353e-05, 0)
AUTO_RK45_LAW = Law(1.69e-11, -0.2045, 0.1079, 0.4474, -0.3123, 16.69, 1e05, 0, 3.845e-12)
RK45_LAW = Law(7.278e-09, -0.1573, 0.1319, 0.2574, -0.2203, 0, 176.1, 0, 2.194e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.7984,
    1.5967,
    -1.2285,
    1.9900,
    0.4179,
    0.0613,
    -1.3636,
    0.3309,
    -1.4613,
    -0.1030,
    0.0652,
    -0.1417,
    0.6980,
    0.0332,
    -0.0539,
    -0.8938,
    -1.1588,
    0.0355,
    -1.5198,
    0.1145,
    -0.1089,
)
IMPLICIT_MORE = (
    -2.7567,
    -0.1066,
    -2.0767,
    0.5813,
    0.5806,
    -0.7793,
    0.3961,
    -2.9879,
    -0.9240,
    1.0125,
    0.2449,
    1.2351,
    -1.8216,
    -0.2147,
    0.2039,
    -0.0420,
    1.8168,
    0.7194,
    0.5815,
    -0.2070,
    0.0957,
)
RK45_MORE = (
    5.2426,
    9.8839,
    -5.3627,
    33.3377,
    -10.9066,
    12.3205,
    -2.3111,
    2.9424,
    -27.4848,
    16.2684,
    -5.5297,
    0.4832,
    16.9822,
    -9.5178,
    3.4806,
    -20.0794,
    14.5522,
    -8.6373,
    -9.7402,
    7.7522,
    -2.2251,
    -34.3875,
)
