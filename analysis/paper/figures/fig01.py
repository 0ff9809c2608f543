"""Figure 1: the chain, the spring, of one cell and of the whole, and the kinetic energy at the middle against N."""

from typing import Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.look import COLOURS
from analysis.notes import chaos_text
from analysis.paper.figures.chain import chain, energy
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.ticks import label
from kernel.laws import PAPER
from kernel.laws.units import K_T, LENGTH

LAYERS = 100  # of the material that the paper's spring was fitted to
CAPTION = (
    "(a) The chain, drawn: an impactor strikes the first of N sites, which springs and dampers join to each other "
    "and to a wall; right, the energy of one spring, with its two stable states. (b) Force against displacement of "
    "one layer (dashed, upper axis) and of the whole material of 100 layers (lower axis). (c) The same without "
    "dimensions; nonlinear in compression only. (d) Peak kinetic energy of the middle site, per length (times N) "
    "and over the initial total energy TE, against the number of unit cells, at (M/M0, V/V0) = (2, 2): linear chain "
    "solid, bistable dashed. Open circles are chaotic."
)


def draw(source: Source) -> Drawn:
    """Force of the spring law from the kernel's constants; energies from the table fig1."""
    df = source.table("fig1")
    figure, axes = style.canvas(2, 3, 10.5, 5.0, width_ratios=(1, 1, 1.6), height_ratios=(0.5, 1))
    grid = axes[0, 0].get_gridspec()
    for ax in axes[0]:
        ax.remove()
    drawing, spring = figure.add_subplot(grid[0, :2]), figure.add_subplot(grid[0, 2])
    chain(drawing)
    energy(spring)
    _springs(axes[1, 0], axes[1, 1])
    numbers = _energies(axes[1, 2], df)
    for ax, name in zip((drawing, *axes[1]), "abcd", strict=True):
        ax.set_title(f"({name})", loc="left")
    return Drawn(figure, numbers, (chaos_text(df, "open circles"),))


def _springs(bulk: Any, unit: Any) -> None:
    e = np.linspace(-0.6, 0.2, 400)
    f = e + PAPER.excess(e)
    bulk.plot(e * LENGTH, f * K_T * LENGTH, color=COLOURS[2], label="whole material")
    cell = bulk.twiny()
    cell.plot(e * LENGTH / LAYERS * 1e3, f * K_T * LENGTH, "--", color=COLOURS[1], label="one layer")
    bulk.set(xlabel="displacement of the whole (m)", ylabel="force (N)")
    cell.set_xlabel("displacement of one layer (mm)")
    handles = [*bulk.get_lines(), *cell.get_lines()]
    bulk.legend(handles=handles, fontsize=8, frameon=False, loc="lower right")
    unit.plot(e, f, color=COLOURS[0])
    for ax in (bulk, unit):
        ax.axhline(0, color="0.8", linewidth=0.6, zorder=0)
        ax.axvline(0, color="0.8", linewidth=0.6, zorder=0)
    unit.set(xlabel="displacement $x$", ylabel="force $f(x)$")


def _energies(ax: Any, df: pd.DataFrame) -> pd.DataFrame:
    shown = df[["N", "zeta_T", "chaotic", "error"]].copy()
    for law in ("linear", "bistable"):
        shown[f"ke_{law}_N"] = df[f"ke_{law}"] * df["N"]
    for colour, (zeta_T, rows) in zip(COLOURS, shown.groupby("zeta_T"), strict=False):
        ax.plot(rows["N"], rows["ke_linear_N"], color=colour, linewidth=1.2)
        style.curve(ax, rows, "N", "ke_bistable_N", colour, label(float(str(zeta_T))), linestyle="--")
    ax.set(xscale="log", yscale="log", xlabel="$N$", ylabel=r"$KE_{N/2}\,N/TE$")
    lines = [line for line in ax.get_lines() if line.get_linestyle() == "--"]
    laws = [ax.plot([], [], dash, color="0.4", label=name)[0] for dash, name in (("-", "linear"), ("--", "bistable"))]
    beside = {"fontsize": 7.5, "frameon": False, "bbox_to_anchor": (1, 0.5)}
    ax.add_artist(ax.legend(handles=lines, title=r"$\zeta_T$", loc="lower left", **beside))
    ax.legend(handles=[*laws, style.open_circle()], loc="upper left", **beside | {"bbox_to_anchor": (1, 0.42)})
    return shown


RECIPES = (Recipe("1", "chain, spring law, and kinetic energy at the middle against N", CAPTION, draw),)
