"""Draw one map: coloured cells over two parameters, each cell at its values, with axes and marks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis import marks
from analysis.colours import Scale
from analysis.plane import matrix
from analysis.ruler import Ruler, ruler
from analysis.table import flagged
from analysis.ticks import label, ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SYMBOLS = {"N": "$N$", "zeta_T": r"$\zeta_T$", "M_over_M0": "$M/M_0$", "V_over_V0": "$V/V_0$"}
WORDS = {
    "N": "number of unit cells",
    "zeta_T": "bulk damping ratio",
    "M_over_M0": "impactor mass",
    "V_over_V0": "impact speed",
}
WORDS_MIN = 1.6  # inches of an axis whose label has room for words


def symbol(name: str) -> str:
    """How an input stands on a picture: a number of the model by its name."""
    return SYMBOLS.get(name, name)


def in_words(name: str) -> str:
    """An input by its words and its symbol: a number of the model has none but its name."""
    return f"{WORDS[name]} {SYMBOLS[name]}" if name in WORDS else name


def placed(values: Mapping[str, float]) -> str:
    """`$N$ = 20, spring.c2 = 4`."""
    return ", ".join(f"{symbol(name)} = {label(value)}" for name, value in values.items())


@dataclass(frozen=True)
class Panel:
    """A drawn map: its mesh, for a colour bar, and how many cells have no number, by fate."""

    mesh: Any
    fates: dict[str, int]


@dataclass(frozen=True)
class Grid:
    """The cells of a map: a ruler for each of the two parameters `over` (across, up)."""

    over: tuple[str, str]
    across: Ruler
    up: Ruler

    def matrix(self, cells: pd.DataFrame, name: str) -> pd.DataFrame:
        """Column `name` of unique cells, (up, across), nan where none."""
        return matrix(cells, self.over, name).reindex(index=self.up.values, columns=self.across.values)

    def places(self, rows: pd.DataFrame) -> "list[NDArray[np.float64]]":
        """Where rows stand on both axes."""
        both = zip((self.across, self.up), self.over, strict=True)
        return [np.array([ruler.place(float(value)) for value in rows[name]]) for ruler, name in both]


def grid(cells: pd.DataFrame, over: Sequence[str], absent: pd.DataFrame | None = None) -> Grid:
    """The grid of all cells, also of those in `absent`, which have no number."""
    frames = [cells] if absent is None else [cells, absent]
    values = [np.unique(np.concatenate([frame[name].to_numpy(np.float64) for frame in frames])) for name in over]
    return Grid((over[0], over[1]), ruler(values[0]), ruler(values[1]))


def panel(
    ax: "Axes", on: Grid, cells: pd.DataFrame, name: str, scale: Scale, absent: pd.DataFrame | None = None
) -> Panel:
    """Draw column `name` of `cells` (one row per cell).

    Chaotic cells are hatched and outlined. Cells without a number are grey by their `fate` in `absent`; of one that is
    in neither frame it is "not computed".
    """
    values = on.matrix(cells, name).to_numpy(np.float64)
    known = ~np.ma.getmaskarray(scale.norm(np.ma.masked_invalid(values)))  # a logarithmic scale has no zero
    spread = on.up.spread(on.across.spread(values, axis=1), axis=0)
    mesh = ax.pcolormesh(
        on.across.borders, on.up.borders, np.ma.masked_invalid(spread), norm=scale.norm, cmap=scale.cmap
    )
    mesh.set_rasterized(True)  # in PDF and SVG an image: no hairlines between cells, small files
    fates = _fates(on, ~known, cells, absent)
    fates[np.isfinite(values) & ~known] = marks.NOT_POSITIVE
    for fate in dict.fromkeys(fates[~known]):
        marks.grey(ax, on.across, on.up, fates == fate, str(fate))
    chaotic = on.matrix(cells.assign(chaos=flagged(cells).astype(float)), "chaos").eq(1.0).to_numpy()
    marks.hatch(ax, on.across, on.up, chaotic & known)
    counted = pd.Series(fates[~known]).value_counts()
    return Panel(mesh, {str(fate): int(count) for fate, count in counted.items()})


def set_axes(ax: "Axes", on: Grid, width: float, height: float) -> None:
    """Set scales, limits, ticks and labels; a label has words if its axis, of so many inches, has room."""
    ax.set_xscale("log" if on.across.log else "linear")
    ax.set_yscale("log" if on.up.log else "linear")
    ax.set(xlim=on.across.borders[[0, -1]], ylim=on.up.borders[[0, -1]])
    for axis, name, inches in ((ax.xaxis, on.over[0], width), (ax.yaxis, on.over[1], height)):
        axis.set_label_text(in_words(name) if inches >= WORDS_MIN else symbol(name))
    set_ticks(ax, on, width, height)


def set_ticks(ax: "Axes", on: Grid, width: float, height: float) -> None:
    """Set as many ticks as axes of so many inches have room for."""
    for axis, of, inches in ((ax.xaxis, on.across, width), (ax.yaxis, on.up, height)):
        marked = ticks(of, inches, across=axis is ax.xaxis)
        axis.set_ticks([of.place(value) for value in marked.places], labels=marked.labels)
        axis.set_ticks(marked.minor, labels=[""] * len(marked.minor), minor=True)


def _fates(on: Grid, missing: NDArray[np.bool_], cells: pd.DataFrame, absent: pd.DataFrame | None) -> NDArray[Any]:
    """Why each cell has no number, (up, across) of str; "" where it has one."""
    found = np.where(missing, marks.NOT_COMPUTED, "").astype(object)
    drawn = on.matrix(cells.assign(there=1.0), "there").notna().to_numpy()
    found[missing & drawn] = marks.NO_NUMBER
    if absent is not None and len(absent):
        fate = on.matrix(absent, "fate")
        found = np.where(missing & ~drawn & fate.notna().to_numpy(), fate.to_numpy(object), found)
    return found
