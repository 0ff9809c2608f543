"""The picture of where a quantity crosses a level: that axis against another one."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.caption import below, sentence
from analysis.look import MARKERS, PLAIN, Look, settings
from analysis.panel import SYMBOLS
from analysis.table import unchecked_words
from analysis.ticks import label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINES_MAX = len(MARKERS)  # curves of a picture; more could not be told apart
_SAID = (
    "Bars: the values between which it is crossed; where they are seen, what lies between is chaotic or not computed."
)


def level_figure(
    found: pd.DataFrame, along: str, across: str, others: list[str], said: str = "", look: Look = PLAIN
) -> "Figure":
    """`found` is what `analysis.crossings` gives; a curve for every combination of the `others`, which vary."""
    with settings():
        figure, axes = style.canvas(1, 1, *(look.size or (5.2, 4.4)))
        ax, crossed = axes[0, 0], found[found["why_not"] == ""]
        groups = list(crossed.groupby(others)) if others else [((), crossed)]
        for k, (_, rows) in enumerate(groups):
            text = ", ".join(f"{_symbol(name)} = {label(float(rows[name].iloc[0]))}" for name in others)
            _curve(ax, rows.sort_values(across), across, text, look.colours(len(groups))[k], MARKERS[k])
        for axis, name in ((ax.xaxis, across), (ax.yaxis, along)):
            values = crossed[["low", "high"]] if name == along else crossed[name]
            if len(crossed) and np.min(values.to_numpy()) > 0:
                (ax.set_xscale if axis is ax.xaxis else ax.set_yscale)("log")
                style.plain_ticks(axis)
        ax.set(xlabel=_symbol(across), ylabel=_symbol(along))
        look.set_limits(ax)
        handles = ax.get_legend_handles_labels()[0] if others else []
        unchecked = sentence(unchecked_words(int(found["unchecked"].sum()), int(found["rows"].sum())))
        names = [name for name in (across, along, *others) if name in SYMBOLS]
        below(figure, handles, names, said, _SAID, unchecked, columns=2)
        return look.finish(figure)


def _curve(ax: Any, rows: pd.DataFrame, x: str, text: str, colour: Any, marker: str) -> None:
    low, high = (rows[name].to_numpy(float) for name in ("low", "high"))
    with np.errstate(invalid="ignore"):
        middle = np.where(low > 0, np.sqrt(low * high), (low + high) / 2)  # of a logarithmic axis, and of any other
    bars = [middle - low, high - middle]
    line = {"color": colour, "linewidth": 0.9, "markersize": 4, "mew": 0}
    ax.errorbar(rows[x], middle, bars, fmt=f"{marker}-", label=text, **line)


def _symbol(name: str) -> str:
    return SYMBOLS.get(name, name)
