"""Finding 4: solitary waves keep their width in sites, so a finer chain dissipates more."""

from typing import Any

import numpy as np
import pandas as pd

from analysis.checks import require
from analysis.paper.findings.finding import Array, Finding, Numbers
from analysis.paper.numbers import MIN_POINTS

CLAIM = "solitary waves keep their width in sites, so pulse length goes with cell size and dissipation grows"
COLUMNS = ("n", "v", "N", "V_over_V0", "law", "against")
KEY = ["against", "law", "N", "V_over_V0"]
# Section 4, on figure 11: the bistable waves "retain a fixed number of particles for their width", the linear pulse
# "encompasses more particles with finer discretization". A profile knows its sites only, so one site is the measure.
WIDTH_TOLERANCE = 1.0
# The fine bistable chain's viscous force is higher "by over a factor of 2" (section 4, on figure 9).
GRADIENT_RATIO = 2.0
RULE = (
    f"bistable: widths within {WIDTH_TOLERANCE:g} site of each other over all N, and over all V/V0; linear: wider at "
    f"every larger N, in all by more than {WIDTH_TOLERANCE:g} site; N times the steepest step of velocity, to which "
    f"viscous force is proportional, at the largest N at least {GRADIENT_RATIO:g} times that of the linear chain and "
    "that of the coarsest bistable one"
)


def solitary_waves(profiles: pd.DataFrame) -> Finding:
    """Whether the width of the leading wave is a number of sites, and what that does to the velocity gradient.

    Columns of figure 11's CSV: velocity `v` (in c0) at site `n` from the peak, for chains of `N` and `law` ("linear",
    "bistable"), `against` "N" or "V" (at one N). Width: full width at half of the peak, in sites, the profile taken
    as straight between sites. InputError for columns that are missing or hold words.
    """
    require(profiles, COLUMNS, "profiles")
    waves = pd.DataFrame([_wave(key, one) for key, one in profiles.groupby(KEY)], columns=[*KEY, "width", "gradient"])
    by_N = waves[waves["against"] == "N"].set_index("N")
    linear, bistable = (by_N[by_N["law"] == law] for law in ("linear", "bistable"))
    speeds = waves[(waves["against"] == "V") & (waves["law"] == "bistable")]
    if min(map(len, (linear, bistable, speeds))) < MIN_POINTS or waves["width"].isna().any():
        why = f"needs whole profiles of both laws at {MIN_POINTS} N, and of the bistable one at {MIN_POINTS} V/V0"
        return Finding(4, CLAIM, None, {"profiles": len(waves)}, why)
    growth = float(np.polyfit(np.log(linear.index.to_numpy(float)), np.log(linear["width"].to_numpy()), 1)[0])
    steep = bistable["gradient"]
    steeper = float(steep.iloc[-1] / max(steep.iloc[0], linear["gradient"].iloc[-1]))
    numbers: Numbers = {
        "bistable width in sites against N": _range(bistable["width"]),
        "against V/V0": _range(speeds["width"]),
        "linear width in sites": _range(linear["width"]),
        "linear width as N to the power": growth,
        "gradient, fine bistable over the next": steeper,
        "profiles": len(waves),
    }
    fixed = all(float(np.ptp(one)) < WIDTH_TOLERANCE for one in (bistable["width"], speeds["width"]))
    grows = bool((np.diff(linear["width"]) > 0).all() and np.ptp(linear["width"]) > WIDTH_TOLERANCE)
    return Finding(4, CLAIM, fixed and grows and steeper >= GRADIENT_RATIO, numbers, RULE)


def _wave(key: Any, one: pd.DataFrame) -> list[Any]:
    """KEY, width and gradient (N times the largest step of velocity between neighbours)."""
    profile = one.sort_values("n")
    n, v = profile["n"].to_numpy(float), profile["v"].to_numpy(float)
    return [*key, half_width(n, v), one["N"].iloc[0] * np.abs(np.diff(v)).max(initial=0.0)]


def half_width(n: Array, v: Array) -> float:
    """Full width, in the units of `n`, of the peak at n = 0 at half its height; nan where it does not fall that far."""
    peak = int(np.argmin(np.abs(n)))
    if not v[peak] > 0 or max(v[: peak + 1].min(), v[peak:].min()) > v[peak] / 2:
        return float("nan")
    from scipy.signal import peak_widths  # takes a tenth of a second to load, which tables of scenes alone need

    whole = tuple(np.array([x]) for x in (v[peak], 0, len(v) - 1))  # of the height, and of all of the profile
    return float(peak_widths(v, [peak], prominence_data=whole)[0][0] * (n[1] - n[0]))


def _range(widths: "pd.Series[float]") -> str:
    return f"{widths.min():.2f} to {widths.max():.2f}"
