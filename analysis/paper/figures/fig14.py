"""Figure 14: ke_ratio against the impact's momentum over the viscous one."""

import pandas as pd

from analysis import style
from analysis.best import best
from analysis.collapse import collapse
from analysis.draw_collapse import scatter
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.plane import plane

CAPTION = (
    "Ratio of the peak kinetic energies at the middle against Pi_IV = M V / 2 zeta_T, the impact's momentum over "
    "the viscous one: (a) the cells of figure 4, "
    "one impact; (b) those of figure 8, the best impact of every N and zeta_T; coloured by N; dashed, "
    "the power law along the lower edge."
)


def draw(source: Source) -> Drawn:
    """From the tables fig4 and fig8."""
    cells = {"a": plane(source.table("fig4")), "b": best(source.table("fig8"))}
    parts = {name: collapse(rows, "Pi_IV") for name, rows in cells.items()}
    figure, axes = style.canvas(1, 2, 7.8, 3.4, sharey=True)
    for ax, rows in zip(axes.flat, parts.values(), strict=True):
        scatter(figure, ax, rows, "N")
    axes[0, 1].set_ylabel("")
    style.letter(axes, ("one impact, (2, 2)", "best of the best"))
    numbers = pd.concat([part.rows.assign(panel=name) for name, part in parts.items()])
    notes = [
        f"({name}) {len(part.rows)} of {len(cells[name])} cells; left out: {part.reasons}; {part}"
        for name, part in parts.items()
    ]
    return Drawn(figure, numbers, tuple(notes))


RECIPES = (Recipe("14", "ke_ratio against Pi_IV", CAPTION, draw),)
