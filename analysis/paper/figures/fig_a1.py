"""Figure A1: force against strain of the whole chain, driven slowly."""

import numpy as np
import pandas as pd

from analysis import style
from analysis.look import COLOURS
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.paper.scenes import Seen
from analysis.ticks import label
from kernel.laws import PAPER

BINS = 50
CAPTION = (
    "Force on the slowly driven end (0.01 of the sound speed) against the strain of the whole chain, (a) without "
    "and (b) with damping (zeta_T = 0.1); the end can only push, so the force is the mean over sixtieths of "
    "strain. Dashed: the spring law, which a chain in step would follow. Past the first maximum the cells snap "
    "one after the other instead, the damped chain later, and the force waits above the law until all have."
)


def draw(source: Source) -> Drawn:
    """A panel per damping, a curve per N."""
    seen = source.scenes("figA1")
    zetas = sorted({one.scene.zeta_T for one in seen})
    figure, axes = style.canvas(1, len(zetas), 3.9 * len(zetas), 3.3, sharey=True)
    tables = []
    for ax, zeta_T in zip(axes.flat, zetas, strict=True):
        for colour, one in zip(COLOURS, [one for one in seen if one.scene.zeta_T == zeta_T], strict=False):
            table = mean_force(one)
            ax.plot(table["strain"], table["force"], color=colour, linewidth=1, label=f"$N$ = {one.scene.N}")
            tables.append(table.assign(N=one.scene.N, zeta_T=zeta_T))
        e = np.linspace(0, 0.8, 200)
        ax.plot(e, e - PAPER.excess(-e), "--", color="0.5", linewidth=1, label="spring law", zorder=0)
        ax.set(xlabel="strain of the chain", xlim=(0, 0.7), ylim=(-0.05, 0.4))
    axes[0, 0].set_ylabel("force ($k_T L$)")
    axes[0, 0].legend(fontsize=8, frameon=False, loc="upper left")
    style.letter(axes, [rf"$\zeta_T$ = {label(zeta_T)}" for zeta_T in zetas])
    return Drawn(figure, pd.concat(tables, ignore_index=True))


def mean_force(one: Seen) -> pd.DataFrame:
    """Strain and force, averaged over equal shares of the run: the contact pushes in short blows."""
    shown = one["quasi_static"]
    # The strain is that of the driven end; the first site bounces off it.
    driven = shown["t"] * one.scene.speed
    strain, force = (
        [float(part.mean()) for part in np.array_split(some[1:], BINS)] for some in (driven, shown["force"])
    )
    return pd.DataFrame({"strain": strain, "force": force})


RECIPES = (Recipe("A1", "quasi-static force against strain", CAPTION, draw),)
