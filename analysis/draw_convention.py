"""How far off the paper's four ke_ratio are, against the factor of each change of convention."""

from typing import TYPE_CHECKING

import pandas as pd

from analysis import style
from analysis.draw import settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def convention_figure(scanned: pd.DataFrame) -> "Figure":
    """A panel per family: ours over the paper's, the shade spanning the neighbours; 1 is agreement."""
    with settings():
        families = list(scanned["family"].unique())
        figure, axes = style.canvas(2, 3, 9.6, 5.6, sharex=True, sharey=True)
        for ax, family in zip(axes.flat, families, strict=True):
            for colour, (key, rows) in zip(
                style.COLOURS, scanned[scanned["family"] == family].groupby("key"), strict=False
            ):
                ax.fill_between(
                    rows["factor"],
                    rows["low"] / rows["paper"],
                    rows["high"] / rows["paper"],
                    color=colour,
                    alpha=0.25,
                    linewidth=0,
                )
                ax.plot(rows["factor"], rows["middle"] / rows["paper"], color=colour, linewidth=1.2, label=str(key))
            ax.axhspan(0.9, 1.1, color="0.85", zorder=0)
            ax.axvline(1, color="0.6", linewidth=0.6, zorder=0)
            ax.set(xscale="log", yscale="log", ylim=(0.3, 300))
            style.plain_ticks(ax.xaxis)
        style.letter(axes, families)
        for ax in axes[-1]:
            ax.set_xlabel("times what is stated")
        for ax in axes[:, 0]:
            ax.set_ylabel("our ke_ratio / the paper's")
        style.legend(figure, axes)
        return figure
