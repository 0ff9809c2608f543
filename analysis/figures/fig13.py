"""Figure 13: ke_ratio against the impact's energy over the chain's."""

import pandas as pd

from analysis import style
from analysis.collapse import collapse, told, with_numbers
from analysis.draw_collapse import AXES
from analysis.errors import InputError
from analysis.figures.recipe import Drawn, Recipe, Source
from analysis.notes import chaos_told
from analysis.table import flagged
from analysis.ticks import label

CAPTION = (
    "Ratio of the peak kinetic energies at the middle against Pi_IE = M V^2, the energy of the impact over the "
    "chain's, for all impacts of figure 5: (a) zeta_T = 0, (b) 4e-5, (c) 4e-4, coloured by N. Without damping N hardly"
    " matters; with it, fine chains stay below 1 over nearly all impacts. Open circles are chaotic."
)


def draw(source: Source) -> Drawn:
    """A panel per zeta_T of the table fig5."""
    df = with_numbers(source.table("fig5"))
    zetas, ns = sorted(df["zeta_T"].unique()), sorted(df["N"].unique())
    figure, axes = style.canvas(1, len(zetas), 3.4 * len(zetas) + 0.3, 3.5, sharey=True)
    for ax, zeta_T in zip(axes.flat, zetas, strict=True):
        some = df[df["zeta_T"] == zeta_T]
        for colour, N in zip(style.COLOURS[1:], ns, strict=False):
            rows = some[some["N"] == N]
            for chaotic, face in ((True, "none"), (False, colour)):
                shown = rows[flagged(rows) == chaotic]
                name = f"$N$ = {N}" if not chaotic else None
                ax.scatter(
                    shown["Pi_IE"],
                    shown["ke_ratio"],
                    s=4,
                    c=face,
                    edgecolors=colour,
                    linewidth=0.4,
                    label=name,
                    rasterized=True,
                )
        ax.axhline(1, color="0.6", linewidth=0.6, zorder=0)
        ax.set(xscale="log", yscale="log", xlabel=AXES["Pi_IE"])
    axes[0, 0].set_ylabel("KE ratio")
    style.letter(axes, [rf"$\zeta_T$ = {label(zeta_T)}" for zeta_T in zetas])
    style.legend(figure, axes, style.open_circle(), markerscale=2.5)
    numbers = df[["N", "zeta_T", "M_over_M0", "V_over_V0", "Pi_IE", "ke_ratio", "error", "chaotic"]]
    notes = [f"zeta_T = {zeta_T:g}: {_judged(df[df['zeta_T'] == zeta_T])}" for zeta_T in zetas]
    return Drawn(figure, numbers, (chaos_told(df, "open circles"), *notes))


def _judged(rows: pd.DataFrame) -> str:
    try:
        return told(collapse(rows, "Pi_IE"))
    except InputError as error:
        return str(error)


RECIPE = Recipe("13", "ke_ratio against Pi_IE", CAPTION, draw, tables=("fig5",))
