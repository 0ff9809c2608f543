"""The picture of where a quantity crosses a level: that axis against another one."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.caption import below, sentence
from analysis.look import MARKERS, PLAIN, Look, settings
from analysis.notes import none_text
from analysis.panel import SYMBOLS
from analysis.table import unchecked_words
from analysis.ticks import label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINES_MAX = len(MARKERS)  # curves of a picture; more could not be told apart
_SAID = "Bars: the values between which it is crossed, neighbours among those that are computed and not chaotic."


def level_figure(
    found: pd.DataFrame,
    along: str,
    across: str,
    others: list[str],
    said: str = "",
    look: Look = PLAIN,
    within: tuple[float, float] = (0.0, 1.0),
) -> "Figure":
    """`found` is what `analysis.crossings` gives; a curve for every combination of the `others`, which vary.

    within: the least and the largest value along the axis in the table, for the picture where nothing is crossed.
    """
    with settings():
        figure, axes = style.canvas(1, 1, *(look.size or (5.2, 4.4)))
        ax, crossed = axes[0, 0], found[found["why_not"] == ""]
        groups = list(crossed.groupby(others)) if others else [((), crossed)]
        for k, (_, rows) in enumerate(groups):
            text = ", ".join(f"{_symbol(name)} = {label(float(rows[name].iloc[0]))}" for name in others)
            _curve(ax, rows.sort_values(across), across, text, look.colours(len(groups))[k], k, len(groups))
        none = none_text(found, "crossing")
        ax.set_xlim(*style.span(found[across].min(), found[across].max()))
        if crossed.empty:
            ax.set_ylim(*style.span(*within))
            style.say_empty(ax, none)
        look.set_limits(ax)
        ends = crossed[["low", "high"]].to_numpy() if len(crossed) else np.array(within)
        for axis, values in ((ax.xaxis, found[across].to_numpy()), (ax.yaxis, ends)):
            if np.min(values) > 0:
                (ax.set_xscale if axis is ax.xaxis else ax.set_yscale)("log")
                style.plain_ticks(axis)
        ax.set(xlabel=_symbol(across), ylabel=_symbol(along))
        handles = ax.get_legend_handles_labels()[0] if others else []
        unchecked = sentence(unchecked_words(int(found["unchecked"].sum()), int(found["rows"].sum())))
        names = [name for name in (across, along, *others) if name in SYMBOLS]
        bars = (_SAID, style.NESTED if len(groups) > 1 else "", none) if len(crossed) else ()
        below(figure, handles, names, said, *bars, unchecked, columns=2)
        return look.finish(figure)


def _curve(ax: Any, rows: pd.DataFrame, x: str, text: str, colour: Any, k: int, n: int) -> None:
    """Curve k of n."""
    low, high = (rows[name].to_numpy(float) for name in ("low", "high"))
    with np.errstate(invalid="ignore"):
        middle = np.where(low > 0, np.sqrt(low * high), (low + high) / 2)  # of a logarithmic axis, and of any other
    bars = [middle - low, high - middle]
    ax.errorbar(rows[x], middle, bars, fmt=f"{MARKERS[k]}-", label=text, color=colour, **style.nested(k, n))


def _symbol(name: str) -> str:
    return SYMBOLS.get(name, name)
