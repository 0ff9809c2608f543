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


FITTED = ("EXPLICIT", "IMPLICIT", "AUTO_RK45", "RK45")  # each _LAW below
# Sites that each integrates at once, before the wave comes (kernel.splitting); Dormand-Prince takes all.
FIRST_SITES = {"EXPLICIT": 32, "IMPLICIT": 64}

# Seconds of one core of the machine of the fit; sweep.plan.speed compares this machine.
EXPLICIT_LAW = Law(7.93e-10, -0.4139, 0.145, 0.2411, 0.09728, 0.7627, 125.3, 7.9e-06, 0, 0.4323)
IMPLICIT_LAW = Law(1.617e-10, -0.4114, 0.0908, 0.08317, -0.1561, 230.7, 309.5, 1.696e-05, 0, 0.5776)
AUTO_RK45_LAW = Law(2.793e-12, -0.3003, 0.1081, 0.6632, -0.4347, 21.69, 1e05, 0, 2.855e-12, 0)
RK45_LAW = Law(2.904e-09, -0.179, 0.1727, 0.3217, -0.1789, 0, 130.1, 0, 9.851e-09, 0)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
# fmt: off
EXPLICIT_MORE = (
    -0.0745, 0.0877, 0.7152, 1.8590, -0.5046, 0.1096, -0.0852,
    -0.0689, -0.7879, 0.3266, -0.2273, 0.4488, 0.5134, -0.6877,
    -0.0349, -1.4361, -1.3278, -0.0090, -1.4178, 0.2460, 0.0144,
)
IMPLICIT_MORE = (
    -1.1924, -1.5864, -1.9911, 0.4889, -0.2187, 0.1663, -0.0947,
    -1.6929, -1.4661, 1.4121, 1.0094, 0.8529, -1.5497, 0.4976,
    -0.2953, -0.5095, 2.2094, 0.3937, -0.5946, 0.2223, -0.2155,
)
RK45_MORE = (
    -0.8138, -1.5324, -0.9095, 1.0312, 0.0514, 0.7076, 1.1506,
    -1.3253, -1.2723, 0.0947, -0.4737, -0.5033, -0.2010, -0.5788,
    0.2517, -0.5144, 0.6012, -0.2170, -2.2065, 0.0431, 0.0207,
    -1.3454,
)
# fmt: on
