"""The cost model's coefficients: data, written by `python -m tests.calibrate --write`."""

from typing import NamedTuple


class Law(NamedTuple):
    """Seconds of both chains: (c a^p V^q M^r (0.01 + zeta)^s + stiff zeta) (impact (n0 + sites) + S + sites T) + start.

    zeta = N zeta_T; a: the splitting's accuracy, or rk45's rtol. T: how long the run is, in times that sound takes
    from site to site; S: that of each site from when the wave reaches it, summed; n0: sites that are integrated at
    once. Of T and S the part after sound has crossed the chain counts less where steps are coarse then. AUTO_RK45_LAW:
    "auto" where it takes Dormand-Prince for the bistable chain, with the splitting's accuracy.
    """

    c: float
    a: float
    V: float
    M: float
    damping: float
    impact: float  # the steps that resolve the impact, in T
    sites: float  # a pass over n sites costs as much as n + this many sites' arithmetic
    start: float
    stiff: float = 0.0
    coarse: float = 0.0  # share of the work after sound has crossed the chain that is done with coarse steps


# Sites that each integrates at once, before the wave comes (kernel.splitting); Dormand-Prince takes all.
FIRST_SITES = {"EXPLICIT": 32, "IMPLICIT": 64}

# Seconds of one core of the machine of the fit; sweep.plan.speed compares this machine.
EXPLICIT_LAW = Law(6.862e-10, -0.4161, 0.1412, 0.2514, 0.1043, 0.3408, 128.8, 6.896e-06, 0, 0.398)
IMPLICIT_LAW = Law(1.338e-10, -0.4146, 0.09903, 0.08665, -0.1552, 234.8, 296.6, 1.689e-05, 0, 0.5012)
AUTO_RK45_LAW = Law(2.517e-12, -0.2975, 0.1121, 0.6613, -0.447, 23.07, 1e05, 0, 2.485e-12, 0)
RK45_LAW = Law(2.549e-09, -0.1821, 0.1664, 0.3178, -0.1798, 0, 117.6, 0, 9.216e-09, 0)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
# fmt: off
EXPLICIT_MORE = (
    -0.4000, 0.2231, 0.2207, 1.7977, -0.2089, -0.1196, -0.0888,
    0.1505, -0.6516, 0.4345, -0.2112, 0.2704, 0.4746, -0.5014,
    -0.1196, -1.7684, -1.3137, -0.0830, -1.4317, 0.2328, -0.0302,
)
IMPLICIT_MORE = (
    -1.3515, -1.5496, -1.9500, 0.5361, -0.1792, 0.1484, -0.0629,
    -2.0640, -1.4703, 1.5963, 0.8216, 0.7194, -1.8701, 0.4421,
    -0.2985, -0.4928, 2.3862, 0.2462, -0.4769, 0.1436, -0.1760,
)
RK45_MORE = (
    -2.7551, -3.2961, -2.2919, 0.1390, -0.3915, 0.6738, -0.0386,
    -2.7161, -2.2914, 0.2707, -0.4111, -1.2575, -1.2487, -0.5524,
    0.4840, -0.9960, 0.9377, 0.0224, -1.8023, -0.0796, 0.0914,
    0.3839,
)
# fmt: on
