"""Figure 9: the viscous force along the chain."""

import pandas as pd

from analysis import style
from analysis.look import COLOURS
from analysis.paper.recipe import Drawn, Recipe, Source

AT = (0.25, 0.5, 1.0, 1.5)  # t/N; the paper does not name its times
CAPTION = (
    "Viscous force along the chain at four times, (M/M0, V/V0) = (2, 2), zeta_T = 4e-5; above the bistable, below "
    "the linear chain; left N = 50, right N = 200. In the fine bistable chain the force comes in more, sharper "
    "and higher spikes. The paper does not name its times; ours are t/N = 0.25, 0.5, 1 and 1.5."
)


def draw(source: Source) -> Drawn:
    """Bistable above, linear below."""
    seen = source.scenes("fig9")
    figure, axes = style.canvas(2, 2, 7.6, 4.8, sharey=True)
    tables = []
    for ax, one in zip(axes.flat, seen, strict=True):
        shown = one["viscous_force"]
        for colour, t in zip(COLOURS, AT, strict=False):
            k = int(abs(shown["t"] - t).argmin())
            ax.plot(shown["link"], shown["force"][k], color=colour, linewidth=0.9, label=f"$t/N$ = {shown['t'][k]:.2g}")
            columns = {"link": shown["link"], "force": shown["force"][k], "t": shown["t"][k]}
            tables.append(pd.DataFrame(columns).assign(N=one.scene.N, law=one.scene.law))
    style.letter(axes, [f"{one.scene.law}, $N$ = {one.scene.N}" for one in seen])
    style.outer_labels(axes, "link $n$", r"viscous force ($k_T L$)")
    style.legend(figure, axes)
    return Drawn(figure, pd.concat(tables, ignore_index=True))


RECIPES = (Recipe("9", "viscous force along the chain", CAPTION, draw),)
