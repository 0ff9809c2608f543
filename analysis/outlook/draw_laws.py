"""Numbers of laws over the plane of c2 and c3, and against the number that predicts them best."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd

from analysis import style
from analysis.colours import shades
from analysis.outlook.laws import BISTABLE, C2, C3, LEVEL_WELLS, MONOTONE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BORDERS = (
    (MONOTONE, ":", r"$c_2^2 = 3 c_3$: above it the force has no falling part"),
    (BISTABLE, "-", r"$c_2^2 = 4 c_3$: above it there is no second stable state"),
    (LEVEL_WELLS, "--", r"$c_2^2 = 4.5 c_3$: below it the second state is the lower one"),
)
SQUARE = 130  # square points, of a law


class Shown(NamedTuple):
    """A number of laws: its column, its interval, its name on an axis, and whether its axis is logarithmic."""

    name: str
    low: str
    high: str
    label: str
    log: bool = False


def planes(rows: pd.DataFrame, shown: Sequence[Shown], speeds: Sequence[float]) -> "Figure":
    """A row of panels per number, a column per impact speed; laws without the number are crosses.

    `rows` have a column `known`: only these are coloured."""
    figure, axes = style.canvas(
        len(shown), len(speeds), 3.0 * len(speeds) + 0.8, 2.9 * len(shown) + 0.7, sharex=True, sharey=True
    )
    for line, one in zip(axes, shown, strict=True):
        scale = shades(rows.loc[rows["known"], one.name].dropna(), log=one.log)
        for ax, V in zip(line, speeds, strict=True):
            _plane(ax, rows[rows["V_over_V0"] == V], one, scale)
            ax.set_title(f"$V/V_0$ = {V:.3g}")
        bar = figure.colorbar(scale, ax=line, label=one.label)
        if one.log:
            style.plain_ticks(bar.ax.yaxis)
    style.outer_labels(axes, "$c_2$", "$c_3$")
    style.legend(figure, axes, columns=2)
    return figure


def _plane(ax: Any, rows: pd.DataFrame, one: Shown, scale: Any) -> None:
    c2 = np.geomspace(rows[C2].min() / 1.08, rows[C2].max() * 1.08, 50)
    low, high = rows[C3].min() / 1.08, rows[C3].max() * 1.08
    for shape, dash, text in BORDERS:
        ax.plot(c2, c2**2 / shape, dash, color="0.35", linewidth=0.9, label=text, zorder=1)
    firm, known = rows[rows["known"]], rows[rows[one.name].notna()]
    ax.plot(known[C2], known[C3], "s", color="0.75", markersize=9, mfc="none", label="$b$ is poorly known", zorder=2)
    colours = scale.to_rgba(firm[one.name].to_numpy(float))
    ax.scatter(firm[C2], firm[C3], SQUARE, colours, marker="s", linewidth=0, zorder=2)
    some = rows[rows[one.name].isna()]
    ax.plot(some[C2], some[C3], "x", color="#D55E00", markersize=5, label="fewer than four transitions")
    ax.set(xscale="log", yscale="log", xlim=c2[[0, -1]], ylim=(low, high))
    style.plain_ticks(ax.xaxis)
    style.plain_ticks(ax.yaxis)


def against(ax: Any, rows: pd.DataFrame, x: str, one: Shown, colours: Sequence[Any], by: str | None = None) -> None:
    """Draw a number of laws with its intervals against a number that predicts it, a colour per value of `by`."""
    groups = [(None, rows)] if by is None else list(rows.groupby(by))
    for (value, some), colour in zip(groups, colours, strict=False):
        known = some[some[one.name].notna() & some[x].notna()]
        bars = np.abs(known[[one.low, one.high]].to_numpy(float).T - known[one.name].to_numpy(float))
        text = None if value is None else f"$V/V_0$ = {float(str(value)):.3g}"
        ax.errorbar(known[x], known[one.name], bars, fmt="o", ms=3.5, lw=0.8, color=colour, mew=0, label=text)
    ax.set(xscale="log", yscale="log" if one.log else "linear", ylabel=one.label)
    ends = rows[[one.low, one.high]].to_numpy(float)
    low, high = np.nanmin(ends), np.nanmax(ends)
    ax.set_ylim((low / 1.15, high * 1.15) if one.log else (low - 0.05, high + 0.05))
    style.plain_ticks(ax.xaxis)
    if one.log:
        style.plain_ticks(ax.yaxis)
