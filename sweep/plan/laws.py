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
EXPLICIT_LAW = Law(1.188e-09, -0.4323, 0.1424, 0.2436, 0.1661, 1.222e-08, 224.1, 3.339e-05, 0)
IMPLICIT_LAW = Law(1.551e-10, -0.4175, 0.1009, 0.08368, -0.1203, 677.5, 50.28, 8.204e-05, 0)
AUTO_RK45_LAW = Law(1.612e-11, -0.2004, 0.1012, 0.4728, -0.2838, 13.63, 1e05, 0, 4.384e-12)
RK45_LAW = Law(6.582e-09, -0.1575, 0.1419, 0.2624, -0.21, 0, 182.2, 0, 1.766e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    -0.5583,
    1.3508,
    -0.9821,
    1.8694,
    0.3790,
    0.0352,
    -1.3306,
    0.2344,
    -1.4002,
    -0.0496,
    0.0555,
    -0.0855,
    0.6461,
    0.0164,
    -0.0705,
    -0.8600,
    -1.1248,
    0.0518,
    -1.4822,
    0.0908,
    -0.0949,
)
IMPLICIT_MORE = (
    -2.7791,
    -0.2084,
    -2.1430,
    0.4438,
    0.5916,
    -0.6745,
    0.3034,
    -3.1853,
    -1.0092,
    1.0843,
    0.2018,
    1.3220,
    -1.4116,
    -0.3501,
    0.1352,
    0.2376,
    1.5151,
    0.6595,
    0.8195,
    -0.0956,
    0.1014,
)
RK45_MORE = (
    -1.5147,
    -3.0413,
    -3.4810,
    5.3442,
    -1.9870,
    1.6443,
    -2.0330,
    -1.6111,
    0.0932,
    -0.1893,
    0.2262,
    -1.0024,
    2.4305,
    -1.1438,
    0.5472,
    -1.8813,
    1.2513,
    -0.8191,
    -0.4820,
    0.3067,
    -0.1814,
    -2.7928,
)
