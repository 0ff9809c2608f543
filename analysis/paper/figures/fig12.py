"""Figure 12: what is left of the energy."""

import pandas as pd

from analysis import style
from analysis.look import COLOURS
from analysis.paper.recipe import Drawn, Recipe, Source

CAPTION = (
    "Total energy over its initial value against time, (M/M0, V/V0) = (2, 2), zeta_T = 4e-5, for N = 50 and 200. "
    "The bistable chain loses more than the linear one, and far more where it is fine."
)


def draw(source: Source) -> Drawn:
    """Linear solid, bistable dashed."""
    figure, axes = style.canvas(1, 1, 4.6, 3.4)
    ax, tables = axes[0, 0], []
    for one in source.scenes("fig12"):
        energy, N, law = one["energy"], one.scene.N, one.scene.law
        colour = COLOURS[1] if N < 100 else COLOURS[2]
        dash = "-" if law == "linear" else "--"
        ax.plot(energy["t"], energy["total"], dash, color=colour, linewidth=1.3, label=f"{law}, $N$ = {N}")
        tables.append(pd.DataFrame(energy).assign(N=N, law=law))
    ax.set(xlabel="$t/N$", ylabel="total energy / TE", xlim=(0, 2.25), ylim=(0, 1.03))
    ax.legend(fontsize=8, frameon=False)
    return Drawn(figure, pd.concat(tables, ignore_index=True))


RECIPES = (Recipe("12", "total energy over time", CAPTION, draw),)
