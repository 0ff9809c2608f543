"""The figures of `best`, three maps beside each other, and of `map`, one plane of the grid."""

from collections.abc import Mapping, Sequence
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis import marks
from analysis.best import guessed, guessed_below, lowest_row
from analysis.caption import below
from analysis.checks import model_axes
from analysis.colours import Scale, bar, plain_scale, ratio_scale
from analysis.look import PLAIN, Look, settings
from analysis.notes import Notes, known_text
from analysis.panel import SYMBOLS, WORDS_MIN, Grid, Panel, grid, in_words, panel, placed, set_axes, set_ticks, symbol
from analysis.quantity import Quantity
from analysis.table import CELL, IMPACT
from analysis.ticks import label
from analysis.wrapped import wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Inches.
_SIDE_MIN, _SIDE_MAX = WORDS_MIN, 2.6  # of a map
_CELL_MAX = 0.5  # of a cell's side, but for the least side: a map of few rows is a strip and not huge blocks
_BESIDE, _AROUND = 1.25, 0.65  # room beside a map for its scale, and for what numbers and words its lower axis has
_BELOW = 1.25  # in a picture of given height, about what legend and small print take
_TITLE_LINE, _TITLE_LETTERS = 0.16, 13  # of a title: the height of a line, and the letters in an inch of it
_BAR_WIDTH = 0.11  # and as much between the map and its bar
_ALONE_MIN, _TITLED_MIN = 4.0, 2.9  # width per map: of one alone, for the small print; of several, for their titles
Map = tuple[str, Scale, str]  # its column, its colours, its title


def best_maps(
    cells: pd.DataFrame,
    others: Mapping[str, NDArray[np.float64]],
    notes: Notes,
    look: Look = PLAIN,
    over: Sequence[str] = ("N", "zeta_T"),
) -> "Figure":
    """Maps over N and zeta_T (the paper's figure 8): lowest ke_ratio, and the M/M0 and V/V0 that gave it.

    `cells` is what `analysis.best` returns. `others` holds all values of the parameters beside `over` in the
    table, so that the colours show where an optimum lies on the edge of what was scanned; one that has a single value
    stands in the title and is not drawn.
    """
    varied = [name for name in others if len(others[name]) > 1]
    impacts = tuple(over) == tuple(CELL) and set(others) <= set(IMPACT)
    all_impacts = "the impacts computed" if notes.lacking else "all impacts"
    named = ", ".join(map(symbol, varied)) or "one row"
    all_of = all_impacts if impacts else f"{named}{' computed' * notes.lacking}"
    apart = " " if set(others) <= set(SYMBOLS) else "\n"  # names of the model's numbers are long
    panels = [_ratio_map(cells, f"lowest {notes.of.title}{apart}over {all_of}", notes, look)]
    panels += [(name, plain_scale(others[name]), f"its {in_words(name)}") for name in varied]
    fixed = {name: float(others[name][0]) for name in others if name not in varied}
    return _maps(cells, over, panels, fixed, notes, look)


def plane_map(cells: pd.DataFrame, over: Sequence[str], notes: Notes, look: Look = PLAIN) -> "Figure":
    """One map of the ratio of a quantity (the paper's figures 4 and 5); `cells` is what `analysis.plane` returns."""
    fixed = {name: float(cells[name].iloc[0]) for name in SYMBOLS if name not in over}
    return _maps(cells, over, [_ratio_map(cells, notes.of.title, notes, look)], fixed, notes, look)


def _ratio_map(cells: pd.DataFrame, title: str, notes: Notes, look: Look) -> Map:
    ratio, scale = notes.of.ratio, ratio_scale if notes.of.is_ratio else plain_scale
    return ratio, scale(cells[ratio].to_numpy(np.float64), look.limits, look.cmap), title


def _maps(
    cells: pd.DataFrame,
    over: Sequence[str],
    panels: Sequence[Map],
    fixed: Mapping[str, float],
    notes: Notes,
    look: Look,
) -> "Figure":
    with settings():
        on = grid(cells, over, notes.absent)
        top = lowest_row(cells, chaotic_too=notes.chaotic_too, of=notes.of)
        letters = [f"({letter}) " for letter in ascii_lowercase] if len(panels) > 1 else [""]
        titles = [letter + title for letter, (*_, title) in zip(letters, panels, strict=False)]
        titles[0] = "\n".join(filter(None, (titles[0], placed(fixed))))
        figure, axes, sides = _figure(on, titles, look)
        for ax, (name, scale, _) in zip(axes, panels, strict=True):
            drawn = panel(ax, on, cells, name, scale, notes.absent)
            set_axes(ax, on, *sides)
            marks.star(ax, *on.places(top))
            if guessed(cells).any():
                x, y = on.places(cells[~guessed(cells)])
                marks.dots(ax, x, y, _cell_points(on, *sides))
            unchecked = notes.unchecked if name == notes.of.ratio else ""
            _beside(figure, ax, drawn, scale, unchecked)
        for ax in axes[1:]:
            ax.set_ylabel("")
            ax.tick_params(labelleft=False)
        lowest = lowest_text(top, list(fixed), notes.of, guessed_below(cells, top, notes.of))
        handles = marks.handles(drawn.fates, notes.hatched, lowest)
        below(figure, handles, (notes.of.meaning, *SYMBOLS), notes.said, grow=look.size is None)
        look.finish(figure)
        for ax in axes:  # ticks again, now that the layout has fixed the sides
            box = ax.get_window_extent()
            set_ticks(ax, on, float(box.width / figure.dpi), float(box.height / figure.dpi))
        return figure


def lowest_text(one: pd.DataFrame, fixed: Sequence[str], of: Quantity, lower: str = "") -> str:
    """The legend's text for the star, at this row (1,); `fixed` are the parameters that are told elsewhere."""
    row = one.iloc[0]
    varied = [name for name in (*SYMBOLS, *model_axes(one)) if name not in fixed]
    place = placed({name: float(row[name]) for name in varied})
    known = "; ".join(filter(None, (known_text(one, of), lower)))
    return f"lowest{' computed' if lower else ''}: {label(float(row[of.ratio]))} at {place}; {known}"


def _figure(on: Grid, titles: Sequence[str], look: Look) -> "tuple[Figure, list[Axes], tuple[float, float]]":
    """A figure, its axes side by side with their titles, and about how many inches each has.

    Unless `look` has its size it has no room yet for what stands below the maps.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    panels = len(titles)
    sides = (np.clip(_CELL_MAX * len(of.values), _SIDE_MIN, _SIDE_MAX) for of in (on.across, on.up))
    across, height = map(float, sides)
    pitch = look.size[0] / panels if look.size else max(across + _BESIDE, _TITLED_MIN if panels > 1 else _ALONE_MIN)
    told = ["\n".join(wrapped(line, int(_TITLE_LETTERS * pitch)) for line in title.split("\n")) for title in titles]
    around = _AROUND + _TITLE_LINE * (1 + max(title.count("\n") for title in told))
    height = look.size[1] - _BELOW - around if look.size else height
    size = look.size or (panels * pitch, height + around)
    figure = Figure(figsize=size, layout=ConstrainedLayoutEngine(w_pad=0.06, wspace=0.02))
    axes = list(figure.subplots(1, panels, squeeze=False)[0])
    for ax, title in zip(axes, told, strict=True):
        ax.set_title(title, loc="left")
    return figure, axes, (pitch - _BESIDE, height)


def _cell_points(on: Grid, width: float, height: float) -> float:
    """The smaller side of a cell, in points, on a map of so many inches."""
    return 72 * min(width / len(on.across.values), height / len(on.up.values))


def _beside(figure: "Figure", ax: "Axes", drawn: Panel, scale: Scale, text: str) -> None:
    """Draw the colour bar: as high as the map, and equally wide beside every map."""
    from matplotlib.transforms import Bbox

    place = ax.inset_axes((1.05, 0, 0.05, 1))

    def locate(_: Any, __: Any) -> Bbox:
        box, inches = ax.get_position(), float(figure.get_size_inches()[0])
        return Bbox.from_bounds(box.x1 + _BAR_WIDTH / inches, box.y0, _BAR_WIDTH / inches, box.height)

    place.set_axes_locator(locate)
    bar(figure, drawn.mesh, scale, text, cax=place)
