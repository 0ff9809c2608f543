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
EXPLICIT_LAW = Law(1.152e-09, -0.4027, 0.1271, 0.266, 0.09666, 0.1163, 190.5, 5.944e-05, 0)
IMPLICIT_LAW = Law(2.242e-10, -0.377, 0.08997, 0.08841, -0.1456, 514.6, 154.9, 8.899e-05, 0)
AUTO_RK45_LAW = Law(1.813e-11, -0.2339, 0.06855, 0.5647, -0.2613, 11.43, 1e05, 0, 9.368e-12)
RK45_LAW = Law(7.185e-09, -0.1651, 0.1314, 0.2574, -0.1768, 0, 209.7, 0, 2.166e-08)
# The expected refinements of certified tasks, in first runs: exp(law @ sweep.plan.cost.features).
EXPLICIT_MORE = (
    0.4226,
    1.0094,
    1.7890,
    2.0690,
    0.5742,
    -0.4236,
    -0.3421,
    -0.0501,
    -1.6541,
    -0.0158,
    -0.0495,
    0.9346,
    0.7616,
    0.0016,
    -0.1678,
    -1.7648,
    -0.3810,
    0.1426,
    -1.6382,
    0.3894,
    -0.0726,
)
IMPLICIT_MORE = (
    -2.5906,
    -0.7637,
    -1.2539,
    0.5849,
    1.3163,
    -0.8710,
    1.2001,
    -1.4680,
    -0.5091,
    1.6679,
    0.8663,
    0.0513,
    -2.5612,
    -0.5788,
    -0.2989,
    0.5583,
    0.8460,
    -0.1755,
    0.1991,
    0.0984,
    -0.4458,
)
RK45_MORE = (
    0.5563,
    -2.1265,
    -0.5743,
    0.8437,
    0.6142,
    0.6071,
    -0.8326,
    -0.9750,
    -0.4945,
    0.6395,
    0.2843,
    -0.0546,
    0.5627,
    -0.2572,
    0.0780,
    -1.2067,
    -1.0723,
    -0.0205,
    -1.1135,
    0.1351,
    -0.1386,
    -2.8174,
)
