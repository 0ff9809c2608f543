"""The stability atlas as a picture: per plane and method a map of the longest stable step, with hatched chaos."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from analysis.atlas import AT, OVER
from analysis.draw import settings
from analysis.panel import CHAOTIC_HATCH, MISSING_COLOUR, SYMBOLS, name_axes, panel
from analysis.plane import matrix
from analysis.stability import LONGEST, METHODS, SHORTEST
from analysis.ticks import label
from kernel.method import SWITCH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIDE, _BESIDE, _ABOVE, _BELOW = 1.9, 1.35, 0.8, 0.7  # inches
_SCALE = np.array([0.01, 0.03, 0.1, 0.3, 1.0, LONGEST])


def atlas_figure(cells: pd.DataFrame) -> "Figure":
    """`cells` is what `analysis.atlas.atlas` returns."""
    from matplotlib.figure import Figure

    with settings():
        width, height = len(METHODS) * (_SIDE + _BESIDE), len(OVER) * (_SIDE + _ABOVE) + _BELOW
        figure = Figure(figsize=(width, height))
        for row, over in enumerate(OVER):
            bottom = _BELOW + (len(OVER) - 1 - row) * (_SIDE + _ABOVE) + _ABOVE / 2
            for column, method in enumerate(METHODS):
                left = column * (_SIDE + _BESIDE) + 0.5 * _BESIDE
                ax = figure.add_axes((left / width, bottom / height, _SIDE / width, _SIDE / height))
                _map(ax, cells[cells["plane"] == row], over, method)
                ax.set_title(f"{method}: {_fixed(over)}", loc="left", fontsize=8)
        _legend(figure)
        return figure


def _map(ax: "Axes", plane: pd.DataFrame, over: Sequence[str], method: str) -> None:
    name_axes(ax, over, _SIDE, _SIDE)
    panel(ax, plane, over, f"step_{method}", _SCALE)
    zeta = matrix(plane.assign(zeta=plane["N"] * plane["zeta_T"]), over, "zeta").to_numpy(dtype=np.float64)
    if zeta.min() < SWITCH < zeta.max():
        x, y = (np.arange(n) + 0.5 for n in zeta.shape[::-1])
        for colour, line in (("white", 3.0), ("black", 1.4)):
            ax.contour(x, y, np.log(zeta / SWITCH), levels=[0.0], colors=colour, linewidths=line)


def _fixed(over: Sequence[str]) -> str:
    return ", ".join(f"{SYMBOLS[name]} = {label(value)}" for name, value in AT.items() if name not in over)


def _legend(figure: "Figure") -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    step = Patch(facecolor="0.5", label="colour: longest stable step, in cell transit times")
    none = Patch(facecolor=MISSING_COLOUR, label=f"shorter than {SHORTEST:.1g}")
    chaos = Patch(
        facecolor="white", edgecolor="black", hatch=CHAOTIC_HATCH, label="chaotic: not determined by the inputs"
    )
    border = Line2D(
        [], [], color="black", linewidth=1.4, label=rf"$N\zeta_T$ = {SWITCH:g}: auto is explicit below, implicit above"
    )
    figure.legend(handles=[step, none, chaos, border], loc="lower center", ncols=2, frameon=False)
