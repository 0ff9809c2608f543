"""The paper's figures: each file says in RECIPES which figures it draws, and stands below in the paper's order."""

from importlib import import_module

from analysis.paper.recipe import Recipe

FILES = (
    "fig01",
    "fig02",
    "fig04",
    "fig05",
    "fig06",
    "fig07",
    "fig08",
    "fig09",
    "fig10",
    "fig11",
    "fig12",
    "fig13",
    "fig14",
    "fig_a1",
)

ALL: tuple[Recipe, ...] = tuple(
    recipe for name in FILES for recipe in import_module(f"analysis.paper.figures.{name}").RECIPES
)
