"""What all figures look like: colours, log-scaled heat maps with hatched chaos, curves with open chaotic marks."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.plane import matrix
from analysis.table import flagged
from analysis.ticks import label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours, apart in every kind of colour vision; the paper's order of curves.
COLOURS = ("#000000", "#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
LABELS = {"N": "$N$", "zeta_T": r"$\zeta_T$", "M_over_M0": "$M/M_0$", "V_over_V0": "$V/V_0$", "ke_ratio": "KE ratio"}
HATCH = "//////"


def canvas(rows: int, columns: int, width: float, height: float, **shared: Any) -> "tuple[Figure, NDArray[Any]]":
    """A figure of panels, in inches, and its axes (rows, columns), each lettered as in the paper."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    # Room between columns: a colour bar's label is not to be read as that of the panel beside it.
    figure = Figure(figsize=(width, height), layout=ConstrainedLayoutEngine(wspace=0.04))
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def letter(axes: Any, titles: Sequence[str] = ()) -> None:
    """(a), (b), .. before each panel's title."""
    for number, ax in enumerate(np.ravel(axes)):
        title = titles[number] if titles else ""
        ax.set_title(f"({'abcdefghijklmnop'[number]}) {title}".rstrip(), loc="left")


def heat(
    ax: "Axes", cells: pd.DataFrame, over: Sequence[str], name: str, low: float, high: float, cmap: str = "viridis"
) -> Any:
    """Column `name` over two parameters, log axes and log colours cut at low and high; chaotic cells hatched."""
    from matplotlib.colors import LogNorm

    grid = matrix(cells, over, name)
    chaotic = matrix(cells.assign(chaotic=flagged(cells)), over, "chaotic").eq(True).to_numpy()
    across, up = (edges(axis.to_numpy(dtype=np.float64)) for axis in (grid.columns, grid.index))
    values = np.ma.masked_invalid(grid.to_numpy(dtype=np.float64))
    mesh = ax.pcolormesh(across, up, values, norm=LogNorm(low, high, clip=True), cmap=cmap, rasterized=True)
    ax.set(xscale="log", yscale="log", xlabel=LABELS[over[0]], ylabel=LABELS[over[1]])
    ax.set_facecolor("0.82")
    _hatch(ax, across, up, chaotic & ~np.ma.getmaskarray(values))
    return mesh


def edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """The borders of cells around ascending positive centres, half-way in the logarithm."""
    logs = np.log(centres)
    if len(logs) == 1:
        return np.array([0.9, 1.1]) * float(centres[0])
    middles = (logs[1:] + logs[:-1]) / 2
    ends = 1.5 * logs[[0, -1]] - 0.5 * logs[[1, -2]]
    borders: NDArray[np.float64] = np.exp(np.concatenate([ends[:1], middles, ends[1:]]))
    return borders


def _hatch(ax: "Axes", across: NDArray[np.float64], up: NDArray[np.float64], where: NDArray[np.bool_]) -> None:
    from matplotlib.collections import PolyCollection

    corners = [
        [(across[x], up[y]), (across[x + 1], up[y]), (across[x + 1], up[y + 1]), (across[x], up[y + 1])]
        for y, x in np.argwhere(where)
    ]
    if corners:
        cells = PolyCollection(corners, facecolor="none", edgecolor=(1, 1, 1, 0.55), linewidth=0, hatch=HATCH)
        ax.add_collection(cells, autolim=False)


def bar(figure: "Figure", mesh: Any, axes: Any, text: str, extend: str = "neither") -> None:
    """The colour bar of one mesh for all `axes`."""
    figure.colorbar(mesh, ax=axes, label=text, extend=extend, pad=0.015, fraction=0.046, aspect=25)


def curve(ax: "Axes", rows: pd.DataFrame, x: str, y: str, colour: str, text: str, **line: Any) -> None:
    """A line over sorted rows; chaotic ones carry an open circle."""
    rows = rows.sort_values(x)
    ax.plot(rows[x], rows[y], color=colour, label=text, **{"linewidth": 1.2, **line})
    open_ones = rows[flagged(rows)]
    ax.plot(open_ones[x], open_ones[y], "o", color=colour, mfc="white", markersize=3, markeredgewidth=0.6)


def legend(figure: "Figure", axes: Any, title: str = "", **options: Any) -> None:
    """One legend for all panels, of all that carries a label, below them."""
    found: dict[str, Any] = {}
    for ax in np.ravel(axes):
        for handle, text in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(text, handle)
    place = {"loc": "outside lower center", "ncols": 4, "frameon": False, "fontsize": 8, **options}
    figure.legend(found.values(), found.keys(), title=title or None, **place)


def plain_ticks(axis: Any) -> None:
    """On a logarithmic axis 0.2, 0.5, 1, 2 instead of powers of ten; on a long one 0.01, 0.1, 1."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 100 * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: label(value)))
    axis.set_minor_formatter(NullFormatter())


def chaotic_note(rows: pd.DataFrame, how: str) -> str:
    """How many of the rows are chaotic, and how they are shown."""
    return f"{len(rows)} rows used, {flagged(rows).sum()} of them chaotic ({how})"
