"""The picture of rows that form no grid: every row a dot where it is, nothing between them."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import marks, style
from analysis.best import lowest_row
from analysis.caption import below
from analysis.checks import model_axes
from analysis.colours import bar, plain_scale, ratio_scale
from analysis.draw import lowest_text
from analysis.look import PLAIN, Look, settings
from analysis.notes import Notes, count
from analysis.panel import SYMBOLS, Grid, grid, set_axes, set_ticks, symbol
from analysis.quantity import Quantity
from analysis.table import flagged
from analysis.ticks import label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE = (4.8, 4.9)  # inches
_MARGIN = 0.06  # of an axis, free at either end: for the star around a point
_DOT, _RING, _LOST = 22, 46, 14  # areas of the marks, in square points


def points_figure(rows: pd.DataFrame, over: Sequence[str], notes: Notes, look: Look = PLAIN) -> "Figure":
    """Dots of `rows`, as `analysis.scatter.scattered` returns them, in the colours of their ratio.

    A chaotic row has a ring; a row without a number, or with one that has no colour, is a grey cross.
    """
    of, varied = notes.of, [name for name in model_axes(rows) if len(rows[name].unique()) > 1]
    inputs = [name for name in rows.columns if name in (*SYMBOLS, *over, *varied)]
    with settings():
        figure, axes = style.canvas(1, 1, *(look.size or _SIZE))
        ax, on = axes[0, 0], grid(rows, over, notes.absent)
        mixed = in_order(rows, over, of)
        x, y = on.places(mixed)
        values = mixed[of.ratio].to_numpy(np.float64)
        scale = (ratio_scale if of.is_ratio else plain_scale)(values, look.limits, look.cmap)
        coloured = ~np.ma.getmaskarray(scale.norm(np.ma.masked_invalid(values)))  # a logarithmic scale has no zero
        dots = ax.scatter(
            x[coloured],
            y[coloured],
            c=values[coloured],
            norm=scale.norm,
            cmap=scale.cmap,
            s=_DOT,
            edgecolor="0.3",
            linewidth=0.3,
            zorder=3,
            clip_on=False,
        )
        chaotic = flagged(mixed)
        ring: dict[str, Any] = {"facecolor": "none", "edgecolor": "black", "linewidth": 0.9, "clip_on": False}
        ax.scatter(x[chaotic], y[chaotic], s=_RING, zorder=3, **ring)
        fates = _lost(ax, on, notes.absent, mixed[~coloured].assign(fate=marks.NOT_POSITIVE))
        set_axes(ax, on, *_SIZE)
        top = lowest_row(rows, chaotic_too=notes.chaotic_too, of=of)
        marks.star(ax, *on.places(top), around=True)
        ax.margins(_MARGIN)
        ax.autoscale()
        bar(figure, dots, scale, notes.unchecked, ax=ax)
        ax.set_title(f"{of.title}, each point where it is", loc="left")
        fixed = [name for name in inputs if name not in over and len(rows[name].unique()) == 1]
        handles = marks.handles({}, "", lowest_text(top, fixed, of))
        if chaotic.any():
            handles.append(_ringed(ring, notes.hatched))
        names = (of.meaning, *(name for name in inputs if name in SYMBOLS))
        below(figure, handles, names, _others(rows, inputs, over), stacked(rows, over), notes.said, fates)
        look.finish(figure)
        box = ax.get_window_extent()  # ticks again, now that the layout has fixed the sides
        width, height = (float(side / figure.dpi) / (1 + 2 * _MARGIN) for side in (box.width, box.height))
        set_ticks(ax, on, width, height)
        return figure


def in_order(rows: pd.DataFrame, over: Sequence[str], of: Quantity) -> pd.DataFrame:
    """The rows as they are drawn, one over the other: mixed, so that no colour hides another.

    Of those at one place the chaotic ones come first, then the others; the lowest comes last of either.
    """
    mixed = rows.sample(frac=1.0, random_state=0)
    place = mixed.groupby(list(over), sort=False).ngroup().to_numpy()
    return mixed.iloc[np.lexsort((-mixed[of.ratio].to_numpy(float), ~flagged(mixed), place))]


def stacked(rows: pd.DataFrame, over: Sequence[str]) -> str:
    """A sentence on the points that lie on each other; empty where none do."""
    places = len(rows[list(over)].drop_duplicates())
    if places == len(rows):
        return ""
    below_others = ", chaotic ones (ringed) below the others" if flagged(rows).any() else ""
    return f"{len(rows)} points lie at {count(places, 'place')}, the lowest on top{below_others}."


def _others(rows: pd.DataFrame, inputs: Sequence[str], over: Sequence[str]) -> str:
    """A sentence on the inputs that are not drawn, and what they range over; empty without any."""
    said = []
    for name in inputs:
        if name not in over:
            low, high = float(rows[name].min()), float(rows[name].max())
            span = f"= {label(low)}" if low == high else f"from {label(low)} to {label(high)}"
            said.append(f"{symbol(name)} {span}")
    return f"Here {', '.join(said)}." if said else ""


def _lost(ax: Any, on: Grid, *frames: pd.DataFrame | None) -> str:
    """Draw the rows that have no colour; how many there are by their `fate`, in words."""
    some = [frame for frame in frames if frame is not None and len(frame)]
    if not some:
        return ""
    counts: Mapping[Any, int] = pd.concat([frame["fate"] for frame in some]).value_counts().to_dict()
    for frame in some:
        ax.scatter(*on.places(frame), marker="x", color="0.6", s=_LOST, linewidth=0.8, zorder=2)
    return f"Grey crosses: {', '.join(f'{count} {fate}' for fate, count in counts.items())}."


def _ringed(ring: Mapping[str, Any], text: str) -> Any:
    from matplotlib.lines import Line2D

    how = {"mfc": "none", "mec": ring["edgecolor"], "mew": ring["linewidth"]}
    return Line2D([], [], marker="o", markersize=7, linestyle="", label=text, **how)
