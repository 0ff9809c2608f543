"""The stability atlas as a picture: two maps of the step, the border of the two schemes, hatched chaos."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.atlas import AT, OVER, TARGET
from analysis.draw import settings
from analysis.panel import CHAOTIC_HATCH, SYMBOLS, name_axes, panel
from analysis.plane import matrix
from analysis.ticks import label
from kernel.splitting.rules import SWITCH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIDE, _BESIDE, _BELOW = 2.6, 1.1, 0.95  # inches
_LEVELS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5)
_SCALE = np.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.4])  # what the steps of the domain span at TARGET
_NAMED = 0.04  # a scheme that has a smaller share of the cells is not named in the map


def atlas_figure(cells: pd.DataFrame) -> "Figure":
    """`cells` is what `analysis.atlas.atlas` returns."""
    from matplotlib.figure import Figure

    with settings():
        size = (2 * (_SIDE + _BESIDE), _SIDE + _BELOW)
        figure = Figure(figsize=size)
        for number, over in enumerate(OVER):
            left = (number * (_SIDE + _BESIDE) + _BESIDE / 2) / size[0]
            ax = figure.add_axes((left, _BELOW / 2 / size[1], _SIDE / size[0], _SIDE / size[1]))
            _map(ax, cells[cells["plane"] == number], over)
            ax.set_title(f"({'ab'[number]}) {_fixed(over)}", loc="left")
        _legend(figure)
        return figure


def _map(ax: "Axes", plane: pd.DataFrame, over: Sequence[str]) -> None:
    name_axes(ax, over, _SIDE, _SIDE)
    panel(ax, plane, over, "step", _SCALE)
    _contours(ax, plane, over)
    methods = matrix(plane, over, "method").to_numpy(dtype=str)
    for method in np.unique(methods).tolist():
        if (methods == method).mean() > _NAMED:
            _name(ax, method, methods == method)


def _contours(ax: "Axes", plane: pd.DataFrame, over: Sequence[str]) -> None:
    """The border of the schemes, and the longest explicit step; over the cells' centres."""
    from matplotlib.patheffects import AbstractPathEffect, withStroke

    bound = matrix(plane, over, "step_explicit").to_numpy(dtype=np.float64)
    x, y = (np.arange(n) + 0.5 for n in bound.shape[::-1])
    edge: list[AbstractPathEffect] = [withStroke(linewidth=1.8, foreground="0.25")]  # to be seen on light cells too
    dashed = ax.contour(x, y, bound, levels=_LEVELS, colors="white", linewidths=0.9, linestyles="dashed")
    dashed.set_path_effects(edge)
    for text in ax.clabel(dashed, fmt="%g", fontsize=7):
        text.set_path_effects(edge)
    zeta = matrix(plane.assign(zeta=plane["N"] * plane["zeta_T"]), over, "zeta").to_numpy(dtype=np.float64)
    if zeta.min() < SWITCH < zeta.max():
        for colour, width in (("white", 4.0), ("black", 1.8)):
            ax.contour(x, y, np.log(zeta / SWITCH), levels=[0.0], colors=colour, linewidths=width)


def _name(ax: "Axes", method: str, where: NDArray[np.bool_]) -> None:
    y, x = np.argwhere(where).mean(axis=0) + 0.5
    box = {"boxstyle": "round", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    ax.text(x, y, method, ha="center", va="center", bbox=box)


def _fixed(over: Sequence[str]) -> str:
    return ", ".join(f"{SYMBOLS[name]} = {label(value)}" for name, value in AT.items() if name not in over)


def _legend(figure: "Figure") -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    step = Patch(facecolor="0.5", label=f"colour: mean step at target {TARGET:g}, in cell transit times")
    chaos = Patch(
        facecolor="white", edgecolor="black", hatch=CHAOTIC_HATCH, label="chaotic: not determined by the inputs"
    )
    bound = Line2D([], [], color="0.5", linestyle="--", linewidth=0.9, label="longest step of the explicit scheme")
    border = Line2D(
        [], [], color="black", linewidth=1.8, label=rf"$N\zeta_T$ = {SWITCH:g}: explicit below, implicit above"
    )
    figure.legend(
        handles=[step, chaos, bound, border], loc="upper left", bbox_to_anchor=(0.02, 0), ncols=2, frameon=False
    )
