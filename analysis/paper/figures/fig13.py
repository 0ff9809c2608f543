"""Figure 13: ke_ratio against the impact's energy over the chain's."""

from typing import Any

import pandas as pd

from analysis import style
from analysis.collapse import NUMBERS, collapse, with_numbers
from analysis.look import COLOURS
from analysis.notes import chaos_text
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.table import flagged
from analysis.ticks import label
from sweep.errors import InputError

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
        _dots(ax, some, dict(zip(ns, COLOURS[1:], strict=False)))
        ax.axhline(1, color="0.6", linewidth=0.6, zorder=0)
        ax.set(xscale="log", yscale="log", xlabel=NUMBERS["Pi_IE"].axis)
    axes[0, 0].set_ylabel("KE ratio")
    style.letter(axes, [rf"$\zeta_T$ = {label(zeta_T)}" for zeta_T in zetas])
    style.legend(figure, axes, style.open_circle())
    numbers = df[["N", "zeta_T", "M_over_M0", "V_over_V0", "Pi_IE", "ke_ratio", "error", "chaotic"]]
    notes = [f"zeta_T = {zeta_T:g}: {_judged(df[df['zeta_T'] == zeta_T])}" for zeta_T in zetas]
    return Drawn(figure, numbers, (chaos_text(df, "open circles"), *notes))


def _dots(ax: Any, rows: pd.DataFrame, colours: dict[int, str]) -> None:
    """Draw the rows as dots, in an order that hides no N; chaotic ones are open circles."""
    rows = rows.sample(frac=1.0, random_state=0)
    edges = [colours[N] for N in rows["N"]]
    faces = ["none" if chaotic else colour for chaotic, colour in zip(flagged(rows), edges, strict=True)]
    line = {"linewidth": 0.4, "rasterized": True}
    ax.scatter(rows["Pi_IE"], rows["ke_ratio"], s=4, c=faces, edgecolors=edges, **line)
    for N, colour in colours.items():
        ax.plot([], [], "o", color=colour, markersize=4, label=f"$N$ = {N}")


def _judged(rows: pd.DataFrame) -> str:
    try:
        return str(collapse(rows, "Pi_IE"))
    except InputError as error:
        return str(error)


RECIPES = (Recipe("13", "ke_ratio against Pi_IE", CAPTION, draw),)
