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
EXPLICIT_LAW = Law(2.713e-09, -0.3735, 0.142, 0.2248, 0.1561, 9.4e-08, 163.4, 2.745e-05, 0)
IMPLICIT_LAW = Law(2.43e-10, -0.4329, 0.1078, 0.1154, -0.1135, 148.2, 148.1, 9.379e-05, 0)
AUTO_RK45_LAW = Law(1.364e-10, -0.1987, 0.1036, 0.5011, -0.3204, 12.71, 1.276e04, 0, 5.038e-11)
RK45_LAW = Law(6.958e-09, -0.1546, 0.1393, 0.2683, -0.2027, 0, 181.2, 0, 1.702e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    0.0396,
    0.6640,
    -0.5362,
    1.1427,
    0.2426,
    -0.0924,
    -1.0863,
    0.0816,
    -1.0832,
    0.2037,
    0.3177,
    0.0066,
    0.3209,
    -0.1306,
    -0.0829,
    -0.6845,
    -0.8208,
    -0.0295,
    -1.3340,
    0.0149,
    -0.1466,
)
IMPLICIT_MORE = (
    -1.8341,
    -0.4338,
    -0.8691,
    -0.0450,
    0.9191,
    -0.4319,
    0.5633,
    -1.9495,
    -0.5398,
    0.7509,
    0.1804,
    0.5855,
    -1.7987,
    -0.2781,
    0.3658,
    0.3624,
    0.7364,
    -0.1180,
    0.4283,
    0.8438,
    -0.5212,
)
RK45_MORE = (
    0.4898,
    -1.8586,
    -0.3589,
    0.4844,
    0.1087,
    0.5213,
    -2.3353,
    -1.0215,
    -1.1622,
    0.8324,
    0.1107,
    -0.1917,
    -0.3420,
    -0.2780,
    0.0451,
    -0.1759,
    0.0670,
    0.0581,
    -0.9000,
    0.0604,
    -0.0688,
    -2.1357,
)
