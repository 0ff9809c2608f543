"""The picture of where a quantity crosses a level: that axis against another one."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis import style
from analysis.caption import below, sentence
from analysis.level import unsure_of
from analysis.look import MARKERS, PLAIN, Look, settings
from analysis.notes import none_text
from analysis.panel import SYMBOLS, placed, symbol
from analysis.ruler import ruler
from analysis.table import unchecked_words
from analysis.ticks import label, ticks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINES_MAX = len(MARKERS)  # curves of a picture; more could not be told apart
_AXIS_SHARE = 0.6  # of the picture's width or height, about
_BEFORE_ZERO, _BEYOND = 0.2, 0.05  # room at the ends: of the way from 0 to the next value; of the axis's logarithm
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
        groups = list(found.groupby(others)) if others else [((), found)]
        groups = [(key, rows) for key, rows in groups if (rows["why_not"] == "").any()]
        for k, (_, rows) in enumerate(groups):
            text = placed({name: float(rows[name].iloc[0]) for name in others})
            _curve(ax, rows.sort_values(across), across, text, look.colours(len(groups))[k], k, len(groups))
        none = none_text(found, "crossing")
        ax.set_xlim(*style.span(found[across].min(), found[across].max()))
        if crossed.empty:
            ax.set_ylim(*style.span(*within))
            style.say_empty(ax, none)
        look.set_limits(ax)
        ends = crossed[["low", "high"]].to_numpy() if len(crossed) else np.array(within)
        _scale(ax, ax.xaxis, np.unique(found[across].to_numpy()))
        _scale(ax, ax.yaxis, np.unique(ends))
        ax.set(xlabel=symbol(across), ylabel=symbol(along))
        handles = ax.get_legend_handles_labels()[0] if others else []
        unchecked = sentence(unchecked_words(int(found["unchecked"].sum()), int(found["rows"].sum())))
        names = [name for name in (across, along, *others) if name in SYMBOLS]
        unsure = f"Of {n} of {len(crossed)} an end is the level within its error." if (n := unsure_of(crossed)) else ""
        bars = (_SAID, unsure, style.NESTED if len(groups) > 1 else "", none) if len(crossed) else ()
        below(figure, handles, names, said, *bars, unchecked, columns=2)
        return look.finish(figure)


def _scale(ax: Any, axis: Any, values: NDArray[np.float64]) -> None:
    """A logarithmic axis, where no value is below 0; as on a map, a zero stands there before the others."""
    across, on, places = axis is ax.xaxis, ruler(values), values.tolist()
    scale, limits = (ax.set_xscale, ax.set_xlim) if across else (ax.set_yscale, ax.set_ylim)
    if places[0] > 0:
        scale("log")
        style.plain_ticks(axis)
        if across and len(places) == 1:  # numbers beside it are of no line
            axis.set_ticks(places, labels=[label(places[0])])
            axis.set_ticks([], minor=True)
    elif on.gap:
        least, most, asked_for = places[1], places[-1], not (across or ax.get_autoscaley_on())
        scale("symlog", linthresh=least)  # even from 0 to the smallest other value
        if not asked_for:
            limits(-_BEFORE_ZERO * least, most * max((most / least) ** _BEYOND, 1 + _BEFORE_ZERO))
        found = ticks(on, _AXIS_SHARE * float(ax.figure.get_size_inches()[0 if across else 1]), across)
        axis.set_ticks(found.places, labels=found.labels)
        axis.set_ticks([], minor=True)


def _curve(ax: Any, rows: pd.DataFrame, x: str, text: str, colour: Any, k: int, n: int) -> None:
    """Curve k of n; its line breaks where the level is not crossed: nothing lies between its neighbours there."""
    crossed = np.flatnonzero(rows["why_not"] == "")
    rows = rows.iloc[crossed[0] : crossed[-1] + 1]
    low, high = (rows[name].to_numpy(float) for name in ("low", "high"))
    with np.errstate(invalid="ignore"):
        middle = np.where(low > 0, np.sqrt(low * high), (low + high) / 2)  # of a logarithmic axis, and of any other
    bars = [middle - low, high - middle]
    ax.errorbar(rows[x], middle, bars, fmt=f"{MARKERS[k]}-", label=text, color=colour, **style.nested(k, n))
