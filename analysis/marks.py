"""Draw what lies over the colours of a map: hatching for chaos, greys for cells without a number, a star."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.ruler import Ruler

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NOT_COMPUTED, FAILED, NO_NUMBER, NOT_POSITIVE = "not computed", "failed", "no number", "zero or negative"
GREYS: Mapping[str, str] = {NOT_COMPUTED: "0.86", FAILED: "0.4", NO_NUMBER: "0.65", NOT_POSITIVE: "0.15"}
HATCH = "//////"
# White lines below black ones: one of the two is visible on every colour.
_LINES = (("white", 1.9, 2.4), ("black", 0.7, 0.9))  # of the hatching, of the outline, in points
_STAR: Any = {"marker": "*", "markersize": 10, "mfc": "white", "mec": "black", "mew": 0.9, "linestyle": ""}
_DOT_SHARE = 0.4  # of a cell's side
_DOT_MIN, _DOT_MAX = 1.6, 4.0  # points across: 4 pixels at the least
_AROUND: Any = {"markersize": 17, "mfc": "none"}  # of a star around a point, which is seen within it

Where = NDArray[np.bool_]


def hatch(ax: "Axes", across: Ruler, up: Ruler, where: Where) -> None:
    """Hatch these cells (up, across) and outline each connected group, so that a single cell is seen too."""
    from matplotlib.collections import PolyCollection

    corners = _corners(across, up, where)
    for colour, lines, width in _LINES if where.any() else ():
        cells = PolyCollection(corners, facecolor="none", edgecolor=colour, linewidth=0)
        cells.set_hatch(HATCH)
        cells.set_hatch_linewidth(lines)
        ax.add_collection(cells, autolim=False)
        outline(ax, across, up, where, colour, width)


def outline(ax: "Axes", across: Ruler, up: Ruler, where: Where, colour: str, width: float) -> None:
    """Draw a line, `width` points wide, around each group of connected cells (up, across)."""
    from matplotlib.collections import LineCollection

    lines = LineCollection(
        _outline(across, up, where), colors=colour, linewidths=width, capstyle="projecting", clip_on=False
    )
    ax.add_collection(lines, autolim=False)


def grey(ax: "Axes", across: Ruler, up: Ruler, where: Where, fate: str) -> None:
    """Fill cells that have no number, each fate with its own grey."""
    from matplotlib.collections import PolyCollection

    if where.any():
        cells = PolyCollection(_corners(across, up, where), facecolor=_grey(fate), linewidth=0, antialiased=False)
        ax.add_collection(cells, autolim=False)


def star(ax: "Axes", x: Any, y: Any, *, around: bool = False) -> None:
    """Mark the lowest; `around`: a point that the star must not cover."""
    ax.plot(x, y, zorder=5, clip_on=False, **_STAR | (_AROUND if around else {}))


def dots(ax: "Axes", x: Any, y: Any, cell: float) -> None:
    """Mark many cells, of about `cell` points a side, on any colour; most of the colour stays to be seen."""
    ax.plot(x, y, "o", markersize=min(max(_DOT_SHARE * cell, _DOT_MIN), _DOT_MAX), mfc="black", mec="white", mew=0.4)


def handles(fates: Mapping[str, int], chaos: str = "", lowest: str = "") -> list[Any]:
    """Entries of a legend: the star, the hatched cells, and the cells without a number by fate; none where empty."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    found: list[Any] = [Line2D([], [], label=lowest, **_STAR)] if lowest else []
    if chaos:
        patch = Patch(facecolor="white", edgecolor="black", linewidth=0.9, hatch=HATCH, label=chaos)
        patch.set_hatch_linewidth(0.7)
        found.append(patch)
    for fate, count in fates.items():
        text = f"{fate}: {count} cell{'s' if count > 1 else ''}"
        found.append(Patch(facecolor=_grey(fate), edgecolor="0.3", linewidth=0.5, label=text))
    return found


def _grey(fate: str) -> str:
    return next((shade for name, shade in GREYS.items() if fate.startswith(name)), GREYS[NOT_COMPUTED])


def _corners(across: Ruler, up: Ruler, where: Where) -> list[list[tuple[float, float]]]:
    boxes = [(*across.cells[x], *up.cells[y]) for y, x in np.argwhere(where)]
    return [[(left, low), (right, low), (right, high), (left, high)] for left, right, low, high in boxes]


def _outline(across: Ruler, up: Ruler, where: Where) -> list[list[tuple[float, float]]]:
    """The borders between a cell of these and any other, or the edge of the map."""
    lines = []
    padded = np.pad(where, 1)
    for y, x in np.argwhere(where):
        (left, right), (low, high) = across.cells[x], up.cells[y]
        sides = {
            (0, -1): [(left, low), (left, high)],
            (0, 1): [(right, low), (right, high)],
            (-1, 0): [(left, low), (right, low)],
            (1, 0): [(left, high), (right, high)],
        }
        lines += [line for (dy, dx), line in sides.items() if not padded[y + 1 + dy, x + 1 + dx]]
    return lines
