"""Figures 2 and 3: the wave in the linear and the bistable chain, for three N, without and with damping."""

from functools import partial

from analysis.paper.figures.fields import fields
from analysis.paper.recipe import Drawn, Recipe, Source

COMMON = (
    "Kinetic energy of every site over the initial total energy, over site and time, for an impact of (M/M0, "
    "V/V0) = (0.5, 4); above the linear, below the bistable chain, N = 50, 100 and 300; colours cut at 1e-4. The "
    "dashed line is the middle site. "
)
UNDAMPED = COMMON + "Without damping: the finer the bistable chain, the more solitary waves share the impact."
DAMPED = COMMON + "With zeta_T = 1e-4: solitary waves slow down and end, and at N = 300 little passes the middle."


def draw(source: Source, name: str) -> Drawn:
    """Linear above, bistable below."""
    seen = source.scenes(name)
    return fields(seen, [f"{one.scene.law}, $N$ = {one.scene.N}" for one in seen], columns=len(seen) // 2)


RECIPES = (
    Recipe("2", "space-time maps of kinetic energy without damping", UNDAMPED, partial(draw, name="fig2")),
    Recipe("3", "space-time maps of kinetic energy with damping", DAMPED, partial(draw, name="fig3")),
)
