"""What several figures share: lettered panels, curves with open circles for chaos, legends, labels of axes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.panel import SYMBOLS
from analysis.quantity import KE, Quantity
from analysis.table import flagged
from analysis.ticks import label
from analysis.wrapped import wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS = {**SYMBOLS, KE.ratio: KE.title}
OPEN = "open circles: chaotic"
_MARK, _LINE = 4.0, 0.9  # points, of the curve that lies on top of the others
_MARK_STEP, _BAR_STEP = 1.6, 0.8  # points by which the marks and bars of each curve below it are larger
NESTED = "Marks within each other, and bars of several colours: curves that agree there."
_SPAN_MARGIN = 0.05  # of an axis, at either end, as matplotlib leaves it
_EMPTY_LETTERS = 45  # of a line that axes of 4 inches have room for


def canvas(rows: int, columns: int, width: float, height: float, **shared: Any) -> "tuple[Figure, NDArray[Any]]":
    """A figure of panels, `width` by `height` inches, and its axes (rows, columns)."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    # Room between columns: a colour bar's label is not to be read as that of the panel beside it.
    figure = Figure(figsize=(width, height), layout=ConstrainedLayoutEngine(wspace=0.04))
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def letter(axes: Any, titles: Sequence[str] = ()) -> None:
    """Write (a), (b), .. before each panel's title."""
    for number, ax in enumerate(np.ravel(axes)):
        title = titles[number] if titles else ""
        ax.set_title(f"({'abcdefghijklmnop'[number]}) {title}".rstrip(), loc="left")


def outer_labels(axes: Any, across: str, up: str) -> None:
    """Label the lowest row and the first column of these axes (rows, columns)."""
    for ax in axes[-1]:
        ax.set_xlabel(across)
    for ax in axes[:, 0]:
        ax.set_ylabel(up)


def against_one(ax: "Axes", across: str, of: Quantity = KE) -> None:
    """Logarithmic axes for a ratio against `across`, with a thin line where both chains are equal."""
    ax.axhline(1, color="0.6", linewidth=0.6, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel=across, ylabel=of.title)


def curve(ax: "Axes", rows: pd.DataFrame, x: str, y: str, colour: str, text: str, **line: Any) -> None:
    """Draw a line through the rows in order of `x`; chaotic rows carry an open circle."""
    rows = rows.sort_values(x)
    ax.plot(rows[x], rows[y], color=colour, label=text, **{"linewidth": 1.2, **line})
    open_ones = rows[flagged(rows)]
    ax.plot(open_ones[x], open_ones[y], "o", color=colour, mfc="white", markersize=3, markeredgewidth=0.6)


def nested(k: int, n: int) -> dict[str, Any]:
    """How curve k of n is drawn, with error bars; a single one has full marks."""
    over = n - 1 - k
    hollow = {"mfc": "none", "mew": _LINE} if n > 1 else {"mew": 0}
    wide = {"markersize": _MARK + _MARK_STEP * over, "elinewidth": _LINE + _BAR_STEP * over}
    return {"linewidth": _LINE, **wide, **hollow}


def span(low: float, high: float) -> tuple[float, float]:
    """The limits of an axis, without a curve on it, of these values: a logarithmic one where both are positive."""
    if low > 0:
        margin = max((high / low) ** _SPAN_MARGIN, 1 + _SPAN_MARGIN)
        return low / margin, high * margin
    margin = _SPAN_MARGIN * (high - low or 1.0)
    return low - margin, high + margin


def say_empty(ax: "Axes", text: str) -> None:
    """Say in the midst of empty axes why nothing is drawn."""
    ax.text(0.5, 0.5, wrapped(text, _EMPTY_LETTERS), transform=ax.transAxes, ha="center", va="center", color="0.3")


def open_circle() -> Any:
    """The legend's entry for the open circles."""
    from matplotlib.lines import Line2D

    look: dict[str, Any] = {"markersize": 4, "markeredgewidth": 0.7, "mfc": "white"}
    return Line2D([], [], marker="o", linestyle="", color="0.3", label=OPEN, **look)


def legend(figure: "Figure", axes: Any, *more: Any, columns: int = 4) -> None:
    """Draw one legend below all panels, of everything that has a label, and of `more`."""
    found: dict[str, Any] = {}
    for ax in np.ravel(axes):
        for handle, text in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(text, handle)
    found |= {handle.get_label(): handle for handle in more}
    figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=columns, frameon=False, fontsize=8)


def plain_ticks(axis: Any) -> None:
    """Label a logarithmic axis 0.2, 0.5, 1, 2, not by powers of ten; a long one 0.1, 1, 10, a short one 1.2, 1.4.

    As long as it is then: its limits must be set before.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

    low, high = axis.get_view_interval()
    if high < 5 * low:  # else fewer than two labels may fall on it
        axis.set_major_locator(MaxNLocator(6, steps=(1, 2, 5, 10)))
        axis.set_minor_locator(NullLocator())
    else:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 100 * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: label(value)))
    axis.set_minor_formatter(NullFormatter())
