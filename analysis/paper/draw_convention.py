"""How far off the paper's four ke_ratio are, against the factor of each change of convention."""

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import pandas as pd

from analysis import style
from analysis.caption import below
from analysis.look import PLAIN, Look, settings
from analysis.paper.convention import CHAIN_FAMILIES, MULTIPLES, TASK_FAMILIES, TOLERANCE
from analysis.paper.numbers import POINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SAID = (
    "Each panel changes one constant of the equations, the same for the paper's four values (fig. 4, 5h, 5l, 8). "
    "Coloured shades: tasks that the paper would print alike; the line is their median."
)


def convention_figure(scanned: pd.DataFrame, look: Look = PLAIN) -> "Figure":
    """A panel per family: ours over the paper's, the shade spanning the neighbours; 1 is agreement."""
    with settings():
        families = list(scanned["family"].unique())
        figure, axes = style.canvas(2, 3, *(look.size or (9.6, 6.2)), sharex=True, sharey=True)
        colours = look.colours(scanned["key"].nunique())
        for ax, family in zip(axes.flat, families, strict=True):
            _panel(ax, scanned[scanned["family"] == family], colours)
            look.set_limits(ax)
            style.plain_ticks(ax.xaxis)
            style.plain_ticks(ax.yaxis)
        style.letter(axes, families)
        style.outer_labels(axes, "times what is stated", "our KE ratio / the paper's")
        handles, _ = axes[0, 0].get_legend_handles_labels()
        below(figure, handles, ("ke_ratio",), _SAID, columns=3)
        return look.finish(figure)


def _panel(ax: Any, family: pd.DataFrame, colours: Sequence[Any]) -> None:
    for colour, (key, rows) in zip(colours, family.groupby("key"), strict=True):
        low, middle, high = (rows[name] / rows["paper"] for name in ("low", "middle", "high"))
        ax.fill_between(rows["factor"], low, high, color=colour, alpha=0.25, linewidth=0)
        ax.plot(rows["factor"], middle, color=colour, linewidth=1.2, label=str(key))
    ax.axhspan(1 - TOLERANCE, 1 + TOLERANCE, color="0.85", zorder=0, label=f"agreement within {TOLERANCE:.0%}")
    ax.axvline(1, color="0.6", linewidth=0.6, zorder=0)
    ax.set(xscale="log", yscale="log", ylim=(0.3, 300))


def rehearse(look: Look) -> "Figure":
    """The picture of agreement everywhere: a --size too small is refused at once."""
    columns = ("paper", "low", "middle", "high")
    rows = [
        {"family": family, "key": point.key, "factor": float(factor)} | dict.fromkeys(columns, point.paper)
        for family, point, factor in product((*TASK_FAMILIES, *CHAIN_FAMILIES), POINTS, MULTIPLES[[0, -1]])
    ]
    return convention_figure(pd.DataFrame(rows), look)
