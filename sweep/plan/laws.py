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
EXPLICIT_LAW = Law(6.089e-10, -0.4197, 0.1393, 0.2558, 0.1731, 4.025e-11, 398.7, 2.228e-05, 0)
IMPLICIT_LAW = Law(1.146e-10, -0.4164, 0.1018, 0.125, -0.1239, 428.8, 100.2, 5.551e-05, 0)
AUTO_RK45_LAW = Law(9.225e-12, -0.2065, 0.1031, 0.5057, -0.292, 18.24, 1e05, 0, 2.761e-12)
RK45_LAW = Law(2.719e-09, -0.1569, 0.1422, 0.2664, -0.2155, 0, 316.3, 0, 7.325e-09)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.4380,
    1.2533,
    -0.8365,
    1.7785,
    0.3845,
    0.0452,
    -1.1926,
    0.2344,
    -1.2749,
    -0.0827,
    0.0153,
    -0.0528,
    0.6159,
    0.0131,
    -0.0812,
    -0.8548,
    -1.1102,
    0.0380,
    -1.4643,
    0.0863,
    -0.0921,
)
IMPLICIT_MORE = (
    -1.9514,
    -0.4717,
    -1.7173,
    -0.3531,
    1.0917,
    -0.4590,
    0.5633,
    -2.1438,
    -0.5523,
    0.8308,
    0.0257,
    1.1752,
    -1.3856,
    -0.3561,
    0.5013,
    0.3982,
    1.0468,
    0.0864,
    0.1930,
    0.4958,
    -0.3733,
)
RK45_MORE = (
    0.2843,
    -2.3434,
    -0.5562,
    0.3147,
    0.2350,
    0.4179,
    -2.9938,
    -1.4784,
    -1.6786,
    1.1137,
    0.0150,
    -0.3756,
    -0.6613,
    -0.0684,
    0.0851,
    -0.9342,
    0.0488,
    0.1025,
    -0.9271,
    0.1230,
    -0.0069,
    -1.4413,
)
