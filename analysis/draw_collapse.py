"""The picture of a ratio against a dimensionless number, with the power law of its lower edge (figures 4d, 14)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from analysis import style
from analysis.caption import below, sentence
from analysis.collapse import NO_FRONT, NUMBERS, Collapse
from analysis.colours import shade_bar, shades
from analysis.front import Front
from analysis.look import PLAIN, Look, settings
from analysis.quantity import ratio
from analysis.table import IMPACT, reasons_text
from analysis.ticks import label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROUNDING = 1e-12  # relative, of a number that went through its logarithm
_LAW_COLOUR, _ZERO_COLOUR = "#D55E00", "0.6"  # of the power law, and of rows where the colouring column is zero


def collapse_figure(found: Collapse, colour: str, look: Look = PLAIN, chain: str = "") -> "Figure":
    """One panel, its dots coloured by the column `colour`. chain: what is said of it."""
    with settings():
        figure, axes = style.canvas(1, 1, *(look.size or (4.8, 4.8)))
        ax = axes[0, 0]
        look.set_limits(ax)
        scatter(figure, ax, found, colour, look)
        handles, _ = ax.get_legend_handles_labels()
        number = NUMBERS[found.against]
        symbols = [name for name in number.parts if name not in IMPACT]  # the meaning explains M and V
        names = tuple(dict.fromkeys((ratio(found.of).meaning, number.meaning, *symbols, colour)))
        below(figure, handles, names, chain, _said(found))
        return look.finish(figure)


def scatter(figure: Any, ax: Any, found: Collapse, colour: str, look: Look = PLAIN) -> None:
    """Draw every row as a dot, in an order that hides no colour, and dashed the power law of the lower edge."""
    from matplotlib.colors import to_rgba

    rows = found.rows.sample(frac=1.0, random_state=0)
    positive = rows.loc[rows[colour] > 0, colour]
    colours = np.full((len(rows), 4), to_rgba(_ZERO_COLOUR))
    if len(positive):
        scale = shades(positive, look.cmap)
        colours[(rows[colour] > 0).to_numpy()] = scale.to_rgba(positive.to_numpy(float))
        shade_bar(figure, ax, scale, positive, style.LABELS[colour])
    if len(positive) < len(rows):
        ax.plot([], [], "o", color=_ZERO_COLOUR, markersize=3, label=f"{style.LABELS[colour]} = 0")
    ax.scatter(rows[found.against], rows[found.of], c=colours, s=5, linewidth=0, rasterized=True)
    if found.front is not None:
        ends = np.array([found.front.start, found.front.end])
        text = f"power law along the lower edge: slope {found.front.s:.2f}; {under(found, found.front)}"
        ax.plot(ends, found.front.A * ends**found.front.s, "--", color=_LAW_COLOUR, linewidth=1.2, label=text)
    style.against_one(ax, NUMBERS[found.against].axis, ratio(found.of))
    style.plain_ticks(ax.yaxis)


def under(found: Collapse, front: Front) -> str:
    """How many rows lie below the power law, and how far: the edge that it is fitted to may be curved."""
    x, y = found.rows[found.against].to_numpy(float), found.rows[found.of].to_numpy(float)
    there = (x >= front.start * (1 - ROUNDING)) & (x <= front.end * (1 + ROUNDING))
    factor = (front.A * x**front.s / y)[there]
    lower = int((factor > 1).sum())
    text = f"{lower} of the {int(there.sum())} rows that it spans lie below"
    return f"{text}, by up to {label(float(factor.max()))} times" if lower else text


def _said(found: Collapse) -> str:
    reasons = reasons_text({why: count for why, count in found.left_out.items() if count})
    left_out = f" Left out: {reasons}." if reasons else ""
    spread = f"Scatter about the running median (1.48 times the median distance): {found.scatter:.3f} decades."
    edge = sentence("" if found.front else NO_FRONT)
    words = (spread, f"{len(found.rows)} rows.{left_out}", edge, sentence(found.unchecked))
    return " ".join(filter(None, words))
