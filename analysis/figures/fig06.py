"""Figure 6: the transition in N, and how it moves with the damping."""

from typing import Any

import numpy as np
import pandas as pd

from analysis.figures import style
from analysis.figures.recipe import Drawn, Recipe, Source, pick
from analysis.figures.steepest import power_law, transitions
from analysis.paper_numbers import EXPONENTS

# The paper's green, red, magenta and grey, and one that it does not have.
COLOURS: dict[tuple[float, float], str] = {
    (2, 1): "#009E73",
    (2, 2): "#D55E00",
    (2, 4): "#CC79A7",
    (0.5, 4): "#0072B2",
    (0.1, 10): "0.45",
}
CAPTION = (
    "(a) Ratio of the peak kinetic energies at the middle against N at zeta_T = 4e-4 for several impacts (M/M0, "
    "V/V0); open circles are chaotic. All but the slowest impact fall sharply from above 1 to far below it at "
    "their N_transition. (b) N_transition, the steepest fall of log ke_ratio against log N on the "
    "grid (bars: the two N it lies between), against zeta_T, with power laws."
)


def draw(source: Source) -> Drawn:
    """(a) from the table fig6, (b) from fig6-damping."""
    df, grid = source.table("fig6"), source.table("fig6-damping")
    figure, axes = style.canvas(1, 2, 8.6, 3.6)
    for (M, V), colour in COLOURS.items():
        style.curve(axes[0, 0], pick(df, M_over_M0=M, V_over_V0=V), "N", "ke_ratio", colour, f"({M:g}, {V:g})")
    axes[0, 0].axhline(1, color="0.6", linewidth=0.6, zorder=0)
    axes[0, 0].set(xscale="log", yscale="log", xlabel="$N$", ylabel="KE ratio")
    axes[0, 0].legend(title="$(M/M_0, V/V_0)$", fontsize=7, title_fontsize=8, frameon=False, loc="lower left")
    tables = [_law(axes[0, 1], grid, impact) for impact in EXPONENTS]
    axes[0, 1].set(xscale="log", yscale="log", xlabel=style.LABELS["zeta_T"], ylabel=r"$N_\mathrm{transition}$")
    axes[0, 1].legend(fontsize=7, frameon=False)
    style.letter(axes)
    numbers = pd.concat([df.assign(panel="a"), pd.concat(tables).assign(panel="b")])
    return Drawn(figure, numbers, (style.chaotic_note(df, "open circles"),))


def _law(ax: Any, grid: pd.DataFrame, impact: tuple[float, float]) -> pd.DataFrame:
    """The transitions of one impact with its line; the columns of `transitions` and the impact."""
    found, colour = transitions(grid, *impact), COLOURS[impact]
    bars = np.abs(found[["from", "to"]].to_numpy().T - found["N"].to_numpy())
    ax.errorbar(found["zeta_T"], found["N"], bars, fmt="o", color=colour, markersize=3.5, linewidth=0.8)
    text = f"({impact[0]:g}, {impact[1]:g})"
    if law := power_law(found):
        text += rf": $b$ = {law.b:.3f} $\pm$ {law.spread:.3f}"
        ax.plot(found["zeta_T"], law.A * found["zeta_T"] ** -law.b, "--", color=colour, linewidth=1)
    ax.plot([], [], "o--", color=colour, label=f"{text} (paper: {EXPONENTS[impact]})")
    return found.assign(M_over_M0=impact[0], V_over_V0=impact[1])


RECIPE = Recipe("6", "transition in N and its power law", CAPTION, draw, tables=("fig6", "fig6-damping"))
