"""N_transition against zeta_T with its power laws (figure 6b)."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.power_law import power_law

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKERS = "osD^vP*X"


def transition_figure(found: pd.DataFrame) -> "Figure":
    """`found` is what `analysis.transition` gives; one colour per impact, bars are N_low and N_high."""
    figure, axes = style.canvas(1, 1, 6.8, 3.6)
    ax, impacts = axes[0, 0], found[found["N_transition"].notna()].groupby(["M_over_M0", "V_over_V0"])
    for k, ((M, V), rows) in enumerate(impacts):
        curve(ax, rows, f"({M:.3g}, {V:.3g})", style.COLOURS[k % len(style.COLOURS)], MARKERS[k % len(MARKERS)])
    finish(ax)
    legend = {"title": "$(M/M_0, V/V_0)$", "fontsize": 7, "title_fontsize": 8, "frameon": False}
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), **legend)
    return figure


def curve(ax: Any, rows: pd.DataFrame, text: str, colour: str, marker: str = "o", paper: float | None = None) -> None:
    """The transitions of one impact, and its power law where there is one, beside the paper's exponent."""
    damped = rows[rows["zeta_T"] > 0]
    bars = np.abs(damped[["N_low", "N_high"]].to_numpy().T - damped["N_transition"].to_numpy())
    line = {"color": colour, "linewidth": 0.9}
    ax.errorbar(damped["zeta_T"], damped["N_transition"], bars, fmt=marker, markersize=3.5, **line)
    if law := power_law(damped):
        text += f": $b$ = {law.b:.3f} ({law.low:.3f} to {law.high:.3f})"
        text += f", paper {paper}" if paper else ""
        ax.plot(damped["zeta_T"], law.A * damped["zeta_T"] ** -law.b, "--", **line)
    ax.plot([], [], f"{marker}--", label=text, **line)


def finish(ax: Any) -> None:
    """Scales and labels."""
    ax.set(xscale="log", yscale="log", xlabel=style.LABELS["zeta_T"], ylabel=r"$N_\mathrm{transition}$")
