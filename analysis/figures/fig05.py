"""Figure 5: ke_ratio over impactor mass and speed."""

import pandas as pd

from analysis import style
from analysis.figures.recipe import Drawn, Recipe, Source
from analysis.plane import plane
from analysis.ticks import label

LOW, HIGH = 1e-2, 1.0  # the paper's colours
OVER = ("M_over_M0", "V_over_V0")
CAPTION = (
    "Ratio of the peak kinetic energies at the middle over impactor mass and speed; rows: zeta_T = 0, 4e-5, 4e-4; "
    "columns: N = 20, 50, 100, 200; colours cut at 1e-2 and 1, as in the paper. Hatched cells are chaotic. "
    "Without damping the bistable chain wins in a narrow band only; with damping and a fine chain over most "
    "impacts."
)


def draw(source: Source) -> Drawn:
    """One panel per zeta_T and N of the table fig5."""
    df = source.table("fig5")
    zetas, ns = sorted(df["zeta_T"].unique()), sorted(df["N"].unique())
    figure, axes = style.canvas(
        len(zetas), len(ns), 2.1 * len(ns) + 0.9, 2.0 * len(zetas) + 0.4, sharex=True, sharey=True
    )
    panels, titles = [], []
    for i, zeta_T in enumerate(zetas):
        for j, N in enumerate(ns):
            cells = plane(df, OVER, {"N": N, "zeta_T": zeta_T})
            mesh = style.heat(axes[i, j], cells, OVER, "ke_ratio", LOW, HIGH)
            axes[i, j].set(xlabel="", ylabel="")
            titles.append(rf"$N$ = {N}, $\zeta_T$ = {label(zeta_T)}")
            panels.append(cells)
    style.letter(axes, titles)
    for ax in axes.flat:
        ax.title.set_fontsize(8)
    figure.supxlabel(style.LABELS[OVER[0]], fontsize=9)
    figure.supylabel(style.LABELS[OVER[1]], fontsize=9)
    style.bar(figure, mesh, axes, "KE ratio", "both")
    numbers = pd.concat(panels)
    return Drawn(figure, numbers, (style.chaotic_note(numbers, "hatched"),))


RECIPE = Recipe("5", "ke_ratio over impactor mass and speed", CAPTION, draw, tables=("fig5",))
