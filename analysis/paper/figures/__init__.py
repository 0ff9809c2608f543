"""The paper's figures: a file figNN each, which says in RECIPES what it draws."""

from importlib import import_module

from analysis.paper.recipe import Recipe

FILES = ("01", "02", "04", "05", "06", "07", "08", "09", "10", "11", "12", "13", "14", "_a1")

ALL: tuple[Recipe, ...] = tuple(
    recipe for name in FILES for recipe in import_module(f"analysis.paper.figures.fig{name}").RECIPES
)
