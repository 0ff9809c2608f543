"""Maps as figures.

matplotlib is imported only when something is drawn, and figures are made without pyplot: no window, no
backend to choose, nothing global is changed, and the user's own matplotlib settings do not enter.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.panel import CHAOTIC_HATCH, MISSING_COLOUR, SYMBOLS, name_axes, panel
from analysis.ticks import label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SETTINGS: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.linewidth": 0.6,
    "hatch.linewidth": 0.6,
    "savefig.dpi": 200,
    "savefig.bbox": "tight",  # labels of any width fit, and strips have no empty space around
    "svg.hashsalt": "analysis",  # one table, one file: without it the ids in an SVG are random
}
# Inches. A map of few rows or columns is drawn as a strip, not as huge blocks.
_SIDE, _CELL, _BESIDE, _BELOW = 2.6, 0.5, 0.9, 0.9
_TITLE = 2.3


def best_maps(cells: pd.DataFrame, impacts: Mapping[str, NDArray[np.float64]]) -> "Figure":
    """Three maps over N and zeta_T (the paper's figure 8): lowest ke_ratio, M/M0 and V/V0 that gave it.

    `cells` is what `analysis.best` returns. `impacts` holds all values of M_over_M0 and V_over_V0 in the
    table, so that the colours show where an optimum lies on the edge of what was scanned.
    """
    over = ("N", "zeta_T")
    with settings():
        figure, axes = _figure(cells, over, 3)
        panel(axes[0], cells, over, "ke_ratio")
        panel(axes[1], cells, over, "M_over_M0", impacts["M_over_M0"])
        panel(axes[2], cells, over, "V_over_V0", impacts["V_over_V0"])
        titles = ("lowest kinetic-energy ratio", "its impactor mass $M/M_0$", "its impact speed $V/V_0$")
        for ax, letter, title in zip(axes, "abc", titles, strict=True):
            ax.set_title(f"({letter}) {title}", loc="left")
        _legend(figure, cells, over, "every impact is chaotic")
        return figure


def plane_map(cells: pd.DataFrame, over: Sequence[str]) -> "Figure":
    """One map of ke_ratio (the paper's figures 4 and 5); `cells` is what `analysis.plane` returns."""
    fixed = [name for name in SYMBOLS if name not in over]
    with settings():
        figure, axes = _figure(cells, over, 1)
        panel(axes[0], cells, over, "ke_ratio")
        at = [f"{SYMBOLS[name]} = {label(float(cells[name].iloc[0]))}" for name in fixed]
        axes[0].set_title(f"kinetic-energy ratio\n{', '.join(at)}", loc="left")
        _legend(figure, cells, over, "chaotic")
        return figure


def save(figure: "Figure", path: Path, kind: str) -> None:
    """Write the figure as "png", "pdf" or "svg"; some settings are looked up only now."""
    dateless = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with settings():
        figure.savefig(path, format=kind, metadata=dateless.get(kind))


@contextmanager
def settings() -> Iterator[None]:
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def _figure(cells: pd.DataFrame, over: Sequence[str], panels: int) -> "tuple[Figure, list[Axes]]":
    """Axes side by side, each in a place of its own size in inches."""
    from matplotlib.figure import Figure

    width, height = (float(np.clip(_CELL * cells[name].nunique(), _CELL, _SIDE)) for name in over)
    step = max(width + _BESIDE, _TITLE)
    size = (panels * step, height + _BELOW)
    figure = Figure(figsize=size)
    axes = []
    for number in range(panels):
        left = (number * step + _BESIDE / 2) / size[0]
        axes.append(figure.add_axes((left, _BELOW / 2 / size[1], width / size[0], height / size[1])))
        name_axes(axes[-1], over, width, height)
    for ax in axes[1:]:  # the same axis as the first one's; its labels would run into the colour bar before
        ax.set_ylabel("")
        ax.tick_params(labelleft=False)
    return figure, axes


def _legend(figure: "Figure", cells: pd.DataFrame, over: Sequence[str], chaotic: str) -> None:
    """Say, below the maps, what hatched and grey cells are, where there are any."""
    from matplotlib.patches import Patch

    shown = cells["ke_ratio"].notna()
    handles = []
    if (cells["chaotic"] & shown).any():
        text = f"{chaotic}: not determined by the inputs"
        handles.append(Patch(facecolor="white", edgecolor="black", hatch=CHAOTIC_HATCH, label=text))
    if shown.sum() < cells[over[0]].nunique() * cells[over[1]].nunique():
        handles.append(Patch(facecolor=MISSING_COLOUR, edgecolor="black", label="no number"))
    if handles:
        columns = min(len(handles), len(figure.axes))
        figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(0, 0), ncols=columns, frameon=False)
