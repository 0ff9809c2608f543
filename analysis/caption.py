"""What stands below a picture: its legend, and a sentence for every symbol on it."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.look import too_small
from analysis.quantity import KE
from analysis.wrapped import wrapped
from kernel.task import M0, V0

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEANINGS = {
    KE.ratio: KE.meaning,
    "N": "$N$: number of unit cells.",
    "zeta_T": r"$\zeta_T$: bulk damping ratio.",
    "M_over_M0": f"$M/M_0$: impactor mass over nominal, $M_0$ = {M0:g} chain masses.",
    "N_transition": r"$N_\mathrm{transition}$: where the KE ratio falls most steeply with $N$, both in logarithms, "
    "in its last fall through 1.",
    "V_over_V0": f"$V/V_0$: impact speed over nominal, $V_0$ = {V0:g} sound speeds.",
}
_FONT_SIZE = 7.5  # points, of legend and small print; the next three follow from it
_LETTERS_PER_INCH = 17
_LINE_HEIGHT = 0.137  # inches
_HANDLE_WIDTH = 0.5  # inches, of the mark before a legend's text
_MARGIN = 0.08  # inches
_MAX_SHARE = 0.8  # of the picture's height, for legend and small print; beyond it too little is left for the panels


def below(
    figure: "Figure", handles: Sequence[Any], names: Sequence[str], *said: str, columns: int = 1, grow: bool = False
) -> None:
    """Put a legend below the panels, and the small print below the legend.

    The small print says what `names` mean (keys of MEANINGS, or the text itself), then what else is `said`. The figure
    must have its final width and a constrained layout, which leaves the room: the height has it, or is to `grow` by it.
    """
    width, height = figure.get_size_inches()
    for handle in handles:
        wide = int(_LETTERS_PER_INCH * (width / columns - _HANDLE_WIDTH))
        handle.set_label(wrapped(str(handle.get_label()), wide))
    meanings = [MEANINGS.get(name, name) for name in names]
    text = wrapped(" ".join(filter(None, [*meanings, *said])), int(_LETTERS_PER_INCH * width))
    print_room = _room(text.count("\n") + 1 if text else 0)
    legend_room = _room(_rows([str(one.get_label()).count("\n") + 1 for one in handles], columns))
    if grow:
        height += print_room + legend_room
        figure.set_size_inches(width, height)
    room = (print_room + legend_room) / height
    if room > _MAX_SHARE:
        raise too_small(figure)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0, room, 1, 1 - room))
    small: dict[str, Any] = {"fontsize": _FONT_SIZE}
    figure.text(_MARGIN / width, print_room / height, text, va="top", linespacing=1.25, **small)
    if handles:
        place: dict[str, Any] = {"bbox_to_anchor": (0, print_room / height), "borderpad": 0.2, "labelspacing": 0.35}
        figure.legend(handles=list(handles), loc="lower left", ncols=columns, frameon=False, **place, **small)


def sentence(words: str) -> str:
    """`words` with a capital and a full stop; no words give no sentence."""
    return f"{words[:1].upper()}{words[1:]}." if words else ""


def _rows(lines: Sequence[int], columns: int) -> float:
    """The height of a legend, in lines, whose labels have this many lines each.

    matplotlib fills one column after the other, and sets the middles of the columns' first labels on one level.
    """
    filled = [column for column in np.array_split(np.array(lines, float), columns) if len(column)]
    above = [(column[0] + 1) / 2 for column in filled]
    under = [column.sum() - top for column, top in zip(filled, above, strict=True)]
    return float(max(above) + max(under)) if filled else 0.0


def _room(lines: float) -> float:
    return lines * _LINE_HEIGHT + _MARGIN if lines else 0.0
