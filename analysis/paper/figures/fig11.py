"""Figure 11: how wide the leading wave is, in sites."""

from typing import Any

import numpy as np
import pandas as pd
from scipy.signal import find_peaks

from analysis import style
from analysis.look import COLOURS
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.paper.scenes import Seen

SITES_SHOWN = {"linear": 60, "bistable": 15}  # sites shown on either side of the peak
PEAK_SHARE = 0.3  # of the highest velocity; a lower peak is no wave of the train
CAPTION = (
    "Velocity profile of the leading wave at t/N = 0.5 without damping, its peak at n = 0; left the linear, right "
    "the bistable chain. Above: several N at (M/M0, V/V0) = (0.5, 4); below: several impact speeds at N = 200. "
    "The linear pulse spans more sites in a finer chain, the solitary wave always the same few, at any speed. In "
    "the linear chain n = 0 is the highest velocity, in the bistable one the foremost peak of the train, as in "
    "the paper."
)


def draw(source: Source) -> Drawn:
    """Against N above, against the impact speed below; a scene may stand in both."""
    numbers = profiles(source)
    figure, axes = style.canvas(2, 2, 7.6, 5.2, sharex="col")
    for row, against in enumerate(("N", "V")):
        for column, law in enumerate(("linear", "bistable")):
            some = numbers[(numbers["against"] == against) & (numbers["law"] == law)]
            _panel(axes[row, column], some, "N" if against == "N" else "V_over_V0")
    style.letter(axes, ["linear", "bistable"] * 2)
    style.outer_labels(axes, "site $n$ from the peak", "velocity ($c_0$)")
    return Drawn(figure, numbers)


def profiles(source: Source) -> pd.DataFrame:
    """Velocity v (in c0) at site n from the peak of the leading wave, of every chain; `against` N or V."""
    seen = source.scenes("fig11")
    ns = [one for one in seen if one.scene.event.V_over_V0 == 4]  # type: ignore[union-attr]
    speeds = sorted((one for one in seen if one.scene.N == 200), key=lambda one: one.scene.speed)
    tables = [_profile(one).assign(against=name) for name, some in (("N", ns), ("V", speeds)) for one in some]
    return pd.concat(tables, ignore_index=True)


def _profile(one: Seen) -> pd.DataFrame:
    v, speed, law = one["profile"]["v"][0], one.scene.event.V_over_V0, one.scene.law  # type: ignore[union-attr]
    n = np.arange(len(v)) - (int(np.argmax(np.abs(v))) if law == "linear" else foremost_peak(v))
    near = np.abs(n) <= SITES_SHOWN[law]
    return pd.DataFrame({"n": n[near], "v": v[near]}).assign(N=one.scene.N, V_over_V0=speed, law=law)


def _panel(ax: Any, some: pd.DataFrame, name: str) -> None:
    for colour, (value, one) in zip(COLOURS, some.groupby(name), strict=False):
        text = f"{style.LABELS[name]} = {value:g}"
        ax.plot(one["n"], one["v"], ".-", color=colour, markersize=3, linewidth=0.9, label=text)
    ax.legend(fontsize=7, frameon=False, loc="upper right")


def foremost_peak(v: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> int:
    """Index of the local maximum farthest from the struck end among those of at least PEAK_SHARE of the highest."""
    peaks, _ = find_peaks(v, height=PEAK_SHARE * v.max())
    return int(peaks[-1]) if len(peaks) else int(v.argmax())


RECIPES = (Recipe("11", "profiles of the leading wave", CAPTION, draw),)
