"""Figure 14: ke_ratio against the impact's momentum over the viscous one."""

import pandas as pd

from analysis.best import best
from analysis.figures import collapse, style
from analysis.figures.recipe import Drawn, Recipe, Source
from analysis.plane import plane

CAPTION = (
    "Ratio of the peak kinetic energies at the middle against Pi_I-V = M V / 2 zeta_T: (a) the cells of figure 4, "
    "one impact; (b) those of figure 8, the best impact of every N and zeta_T; coloured by N."
)


def draw(source: Source) -> Drawn:
    """From the tables fig4 and fig8."""
    parts = {"a": plane(source.table("fig4")), "b": best(source.table("fig8"), chaotic_too=True)}
    figure, axes = style.canvas(1, 2, 7.8, 3.4, sharey=True)
    for ax, rows in zip(axes.flat, parts.values(), strict=True):
        collapse.scatter(figure, ax, rows, "Pi_IV", "N")
    axes[0, 1].set_ylabel("")
    style.letter(axes, ("one impact, (2, 2)", "best of the best"))
    numbers = pd.concat([collapse.numbers(rows).assign(panel=name) for name, rows in parts.items()])
    return Drawn(figure, numbers, (style.chaotic_note(numbers, "drawn as the others"),))


RECIPE = Recipe("14", "ke_ratio against Pi_I-V", CAPTION, draw, tables=("fig4", "fig8"))
