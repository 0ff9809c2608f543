"""The paper's figures, one recipe each."""

from analysis.figures import (
    fig01,
    fig02,
    fig04,
    fig05,
    fig06,
    fig07,
    fig08,
    fig09,
    fig10,
    fig11,
    fig12,
    fig13,
    fig14,
    fig_a1,
)
from analysis.figures.recipe import Drawn, Recipe, Source

ALL: tuple[Recipe, ...] = (
    fig01.RECIPE,
    fig02.RECIPE_2,
    fig02.RECIPE_3,
    *(part.RECIPE for part in (fig04, fig05, fig06, fig07, fig08, fig09, fig10, fig11, fig12, fig13, fig14, fig_a1)),
)

__all__ = ["ALL", "Drawn", "Recipe", "Source"]
