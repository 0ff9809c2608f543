"""Figure 5: ke_ratio over impactor mass and speed."""

import pandas as pd

from analysis import style
from analysis.colours import bar, ratio_scale
from analysis.notes import chaos_text
from analysis.panel import grid, panel, set_axes
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.plane import plane
from analysis.ticks import label

LOW, HIGH = 1e-2, 10.0  # of the colours; the paper's end at 1
SIDE = 1.6  # inches, about, of a map
OVER = ("M_over_M0", "V_over_V0")
CAPTION = (
    "Ratio of the peak kinetic energies at the middle over impactor mass and speed; rows: zeta_T = 0, 4e-5, 4e-4; "
    "columns: N = 20, 50, 100, 200; blue where the bistable chain protects better, red where worse (the paper cuts its "
    "colours at 1). Hatched cells are chaotic, that is sensitive to their inputs. "
    "Without damping the bistable chain wins in a narrow band only; with damping and a fine chain over most "
    "impacts."
)


def draw(source: Source) -> Drawn:
    """One panel per zeta_T and N of the table fig5."""
    df = source.table("fig5")
    zetas, ns = sorted(df["zeta_T"].unique()), sorted(df["N"].unique())
    figure, axes = style.canvas(len(zetas), len(ns), 2.1 * len(ns) + 0.9, 2.0 * len(zetas) + 0.4)
    panels, titles = [], list[str]()
    scale = ratio_scale(df["ke_ratio"].to_numpy(float), (LOW, HIGH))
    for i, zeta_T in enumerate(zetas):
        for j, N in enumerate(ns):
            cells = plane(df, OVER, {"N": N, "zeta_T": zeta_T})
            on = grid(cells, OVER)
            drawn = panel(axes[i, j], on, cells, "ke_ratio", scale)
            set_axes(axes[i, j], on, SIDE, SIDE)
            axes[i, j].set(xlabel="", ylabel="")
            axes[i, j].label_outer()
            titles.append(rf"$N$ = {N}, $\zeta_T$ = {label(zeta_T)}")
            panels.append(cells)
    style.letter(axes, titles)
    for ax in axes.flat:
        ax.title.set_fontsize(8)
    figure.supxlabel(style.LABELS[OVER[0]], fontsize=9)
    figure.supylabel(style.LABELS[OVER[1]], fontsize=9)
    bar(figure, drawn.mesh, scale, "KE ratio", ax=axes)
    numbers = pd.concat(panels)
    return Drawn(figure, numbers, (chaos_text(numbers, "hatched"),))


RECIPES = (Recipe("5", "ke_ratio over impactor mass and speed", CAPTION, draw),)
