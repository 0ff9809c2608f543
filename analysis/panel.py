"""One map: coloured cells over two parameters, axes, colour bar, hatching.

Colours are viridis for ke_ratio and cividis for the impact: even in lightness, so they survive grey print
and every kind of colour vision.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.plane import matrix
from analysis.table import flagged
from analysis.ticks import label, ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize

SYMBOLS = {"N": "$N$", "zeta_T": r"$\zeta_T$", "M_over_M0": "$M/M_0$", "V_over_V0": "$V/V_0$"}
WORDS = {
    "N": "number of unit cells",
    "zeta_T": "bulk damping ratio",
    "M_over_M0": "impactor mass",
    "V_over_V0": "impact speed",
}
CUT = 1.0  # from here on the bistable chain is worse than the linear one; by how much the paper does not show
MISSING_COLOUR = "0.82"
CHAOTIC_HATCH = "/////"

_TICKED_SCALE = 6  # a scale of up to so many values is labelled with these
_BAR = 0.11  # inches
_WORDS_FIT = 1.6  # inches of axis from which its label has room for words


def panel(
    ax: "Axes",
    cells: pd.DataFrame,
    over: Sequence[str],
    name: str,
    scale: NDArray[np.float64] | None = None,
) -> None:
    """Draw column `name` of `cells` (one row per cell) over the two parameters `over` (across, up).

    ke_ratio has a logarithmic colour scale cut at 1; another column is given the values that its `scale`
    spans. Chaotic cells are hatched, cells without a number grey.
    """
    grid = matrix(cells, over, name)
    chaotic = matrix(cells.assign(chaotic=flagged(cells)), over, "chaotic").eq(True).to_numpy()
    values = np.ma.masked_invalid(grid.to_numpy(dtype=np.float64))
    norm = _ratio_norm(values) if scale is None else _scale_norm(scale)
    mesh = ax.pcolormesh(values, norm=norm, cmap="cividis" if scale is not None else "viridis")
    mesh.set_rasterized(True)  # in PDF and SVG an image: no hairlines between cells, small files
    _hatch(ax, norm(values), chaotic & ~np.ma.getmaskarray(values))
    _axis(ax.xaxis, grid.columns.to_numpy(dtype=np.float64), ax.axvline)
    _axis(ax.yaxis, grid.index.to_numpy(dtype=np.float64), ax.axhline)
    ax.set_facecolor(MISSING_COLOUR)
    _bar(ax, mesh, scale, cut=scale is None and bool((values > CUT).any()))


def name_axes(ax: "Axes", over: Sequence[str], width: float, height: float) -> None:
    """Label the axes of a map of so many inches: in words where they have room."""
    across, up = (
        f"{WORDS[name]} {SYMBOLS[name]}" if inches >= _WORDS_FIT else SYMBOLS[name]
        for name, inches in zip(over, (width, height), strict=True)
    )
    ax.set(xlabel=across, ylabel=up)


def _ratio_norm(values: "np.ma.MaskedArray[Any, np.dtype[np.float64]]") -> "Normalize":
    from matplotlib.colors import LogNorm

    positive = values[values > 0].compressed()
    lowest = float(positive.min()) if len(positive) else CUT
    # At least a decade, so that small differences do not look large.
    return LogNorm(min(lowest, CUT / 10), CUT, clip=True)


def _scale_norm(scale: NDArray[np.float64]) -> "Normalize":
    from matplotlib.colors import LogNorm, Normalize

    low, high = float(scale.min()), float(scale.max())
    if low <= 0:
        return Normalize(low, high if high > low else low + 1)
    return LogNorm(low, high) if high > low else LogNorm(low / 2, high * 2)


def _hatch(ax: "Axes", shades: NDArray[np.float64], where: NDArray[np.bool_]) -> None:
    """Hatch cells, white on dark colours and black on light ones."""
    from matplotlib.collections import PolyCollection

    shades = np.ma.filled(shades, 0.0)
    for colour, some in (("white", where & (shades < 0.6)), ("black", where & (shades >= 0.6))):
        corners = [[(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)] for y, x in np.argwhere(some)]
        if corners:
            cells = PolyCollection(corners, facecolor="none", edgecolor=colour, linewidth=0)
            cells.set_hatch(CHAOTIC_HATCH)
            ax.add_collection(cells, autolim=False)


def _axis(axis: Any, values: NDArray[np.float64], line: Any) -> None:
    marks = ticks(values)
    axis.set_ticks([place + 0.5 for place in marks.positions], labels=marks.labels)
    axis.set_ticks([place + 0.5 for place in marks.minor], minor=True)
    if len(values) > 1 and values[0] == 0:
        line(1, color="white", linewidth=1.2)  # zero is no neighbour of the smallest positive value


def _bar(ax: "Axes", mesh: Any, scale: NDArray[np.float64] | None, cut: bool) -> None:
    from matplotlib.ticker import FuncFormatter

    figure: Any = ax.get_figure()
    # In the map's own coordinates: exactly as high as the map, and equally wide beside every map.
    inches = float(ax.get_window_extent().width / figure.dpi)
    place = ax.inset_axes((1 + _BAR / inches, 0, _BAR / inches, 1))
    bar = figure.colorbar(mesh, cax=place, extend="max" if cut else "neither")
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: label(value)))
    bar.ax.yaxis.set_minor_formatter("")
    if scale is not None and len(scale) <= _TICKED_SCALE:
        bar.set_ticks(scale.tolist())
        bar.minorticks_off()
