"""Pictures whose numbers take minutes are drawn from made-up ones first: a --size that is too small is told at once."""

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import atlas, convention, tradeoff
from analysis.draw_atlas import atlas_figure
from analysis.draw_convention import convention_figure
from analysis.draw_tradeoff import tradeoff_figure
from analysis.look import Look
from analysis.paper_numbers import POINTS
from analysis.stability import METHODS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VALUES = ("paper", "low", "middle", "high")


def of_tradeoff(tasks: int, look: Look) -> "Figure":
    """Every point, on straight lines."""
    points = [_point(setting) for setting in tradeoff.settings()]
    return tradeoff_figure(pd.DataFrame(points), tasks, look)


def _point(one: tradeoff.Setting) -> dict[str, Any]:
    errors = {"error_50": one.setting / 2, "error_90": one.setting}
    work = dict.fromkeys(("ms_50", "ms_mean", "evaluations_per_time_50"), one.setting**-0.25)
    return {"method": one.method, "setting": one.setting, "ode45_defaults": one.ode45} | errors | work


def of_atlas(look: Look) -> "Figure":
    """Few cells, with all that a legend may have to tell."""
    cells = atlas.tasks(2).assign(method=METHODS[0], chaotic=True, checked=True)
    cells = cells.assign(**{f"step_{method}": 1.0 for method in METHODS})
    cells.loc[0, ["checked", "chaotic"]] = False
    cells.loc[1, f"step_{METHODS[0]}"] = np.nan
    return atlas_figure(cells, look)


def of_convention(look: Look) -> "Figure":
    """Every family and number of the paper, and agreement everywhere."""
    families = (*convention.TASK_FAMILIES, *convention.CHAIN_FAMILIES)
    rows = [
        {"family": family, "key": point.key, "factor": float(factor)} | dict.fromkeys(VALUES, point.paper)
        for family, point, factor in product(families, POINTS, convention.FACTORS[[0, -1]])
    ]
    return convention_figure(pd.DataFrame(rows), look)
