"""Figure 8: the best of the best."""

import pandas as pd

from analysis import marks, style
from analysis.best import best, lowest_row
from analysis.colours import bar, plain_scale, ratio_scale
from analysis.notes import chaos_text
from analysis.panel import grid, panel, set_axes
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.table import flagged, looked_for_chaos

LOW, HIGH = 1e-3, 10.0
IMPACTS = (0.1, 10.0)
SIDES = (2.6, 2.6)  # inches, about, of a map
OVER = ("N", "zeta_T")
CAPTION = (
    "(a) The lowest ratio of the peak kinetic energies over all impacts, for every N and zeta_T; (b) the impactor "
    "mass and (c) the impact speed that gave it. As in the paper, chaotic rows compete; cells whose best row is "
    "chaotic are hatched, their value is one draw of many. The star marks the lowest that is not chaotic; grey cells "
    "have no finished row."
)


def draw(source: Source) -> Drawn:
    """From the table fig8, chaotic rows competing as the paper had them."""
    rows = source.table("fig8")
    cells = best(rows, chaotic_too=True)
    figure, axes = style.canvas(1, 3, 10.5, 3.3, sharey=True)
    figure.set_layout_engine("constrained", wspace=0.08)  # each panel's colour bar nearer to it than to the next
    on, names = grid(cells, OVER), ("ke_ratio", "M_over_M0", "V_over_V0")
    for ax, name in zip(axes[0], names, strict=True):
        values = cells[name].to_numpy(float)
        scale = ratio_scale(values, (LOW, HIGH)) if name == "ke_ratio" else plain_scale(values, IMPACTS)
        drawn = panel(ax, on, cells, name, scale)
        set_axes(ax, on, *SIDES)
        bar(figure, drawn.mesh, scale, style.LABELS[name], ax=ax)
        marks.star(ax, *on.places(lowest_row(cells)))
    for ax in axes[0, 1:]:
        ax.set_ylabel("")
    style.letter(axes, ("lowest KE ratio", "its impactor mass", "its impact speed"))
    return Drawn(figure, cells, (_note(rows, cells),))


def _note(rows: pd.DataFrame, cells: pd.DataFrame) -> str:
    won = f"; {int(flagged(cells).sum())} of {len(cells)} cells won by a chaotic row (hatched)"
    return chaos_text(rows, "competing") + (won if looked_for_chaos(rows) else "")


RECIPES = (Recipe("8", "best of the best: lowest ke_ratio and its impact", CAPTION, draw),)
