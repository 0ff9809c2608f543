"""Figure 4: ke_ratio for one impact over N and zeta_T, its slices, and against N/zeta_T."""

from typing import Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.best import lowest_row
from analysis.collapse import collapse
from analysis.colours import bar, ratio_scale
from analysis.draw_collapse import scatter
from analysis.look import COLOURS
from analysis.notes import chaos_text
from analysis.panel import grid, panel, set_axes
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.plane import chosen, plane
from analysis.ticks import label

LOW, HIGH = 0.1, 10.0  # of the colours; the paper's reach from 0.01 to 1
SIDES = (3.0, 2.5)  # inches, about, of the map
ZETAS = (4e-5, 4e-4, 4e-3, 4e-2, 4e-1)
CHAINS = (5, 20, 50, 100, 200, 500)
CAPTION = (
    "Ratio of the peak kinetic energies at the middle, bistable over linear, for (M/M0, V/V0) = (2, 2). (a) Over N and"
    " zeta_T, blue below 1, red above; hatched cells are chaotic, that is sensitive to their inputs. (b) Against N for"
    " several zeta_T and without damping. (c) Against zeta_T for several N. (d) All cells against N/zeta_T, coloured "
    "by zeta_T, and the power law along their lower edge. Open circles are chaotic."
)


def draw(source: Source) -> Drawn:
    """(a), (c), (d) from the table fig4, (b) from fig1."""
    cells = plane(source.table("fig4"))
    slices = source.table("fig1")
    figure, axes = style.canvas(2, 2, 8.4, 6.4)
    on, scale = grid(cells, ("N", "zeta_T")), ratio_scale(cells["ke_ratio"].to_numpy(float), (LOW, HIGH))
    drawn = panel(axes[0, 0], on, cells, "ke_ratio", scale)
    set_axes(axes[0, 0], on, *SIDES)
    bar(figure, drawn.mesh, scale, "KE ratio", ax=axes[0, 0])
    _against_n(axes[0, 1], slices)
    _against_zeta(axes[1, 0], cells)
    both = collapse(cells, "N_over_zeta_T")
    scatter(figure, axes[1, 1], both, "zeta_T")
    style.letter(axes)
    numbers = pd.concat([cells.assign(panel="acd"), slices[cells.columns].assign(panel="b")])
    of_all, firm = (_place(lowest_row(cells, chaotic_too=too)) for too in (True, False))
    note = f"lowest {of_all}; lowest that is not chaotic {firm}"
    return Drawn(figure, numbers, (chaos_text(cells, "hatched, open circles; not in (d)"), note, f"(d) {both}"))


def _place(one: pd.DataFrame) -> str:
    row = one.iloc[0]
    return f"{row['ke_ratio']:.3g} at N = {row['N']:.0f}, zeta_T = {row['zeta_T']:.3g}"


def _against_n(ax: Any, rows: pd.DataFrame) -> None:
    for colour, zeta_T in zip(COLOURS, (0.0, *ZETAS), strict=False):
        style.curve(ax, chosen(rows, {"zeta_T": zeta_T}), "N", "ke_ratio", colour, label(zeta_T))
    _finish(ax, "$N$", r"$\zeta_T$", "lower left")


def _against_zeta(ax: Any, cells: pd.DataFrame) -> None:
    there = cells["N"].unique()
    for colour, N in zip(COLOURS, CHAINS, strict=False):
        nearest = int(there[np.abs(np.log(there / N)).argmin()])
        style.curve(ax, cells[cells["N"] == nearest], "zeta_T", "ke_ratio", colour, str(nearest))
    _finish(ax, r"$\zeta_T$", "$N$", "upper right")


def _finish(ax: Any, across: str, title: str, place: str) -> None:
    style.against_one(ax, across)
    style.plain_ticks(ax.yaxis)
    low, high = ax.get_ylim()  # and room for the legend
    ax.set_ylim(*((low / 3, high) if place == "lower left" else (low, 3 * high)))
    handles = [*ax.get_legend_handles_labels()[0], style.open_circle()]
    ax.legend(handles=handles, title=title, fontsize=7, title_fontsize=8, frameon=False, loc=place, ncols=2)


RECIPES = (Recipe("4", "ke_ratio over N and zeta_T at (2, 2), with slices", CAPTION, draw),)
