"""ke_ratio against one dimensionless number, with its lower front (figures 4d, 13, 14)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from analysis import style
from analysis.collapse import Collapse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AXES = {
    "Pi_IE": r"$\Pi_{I-E} = M V^2$",
    "Pi_IV": r"$\Pi_{I-V} = M V / 2\zeta_T$",
    "N_over_zeta_T": r"$N/\zeta_T$",
}


def collapse_figure(found: Collapse, colour: str) -> "Figure":
    """One panel, its dots coloured by the column `colour`."""
    figure, axes = style.canvas(1, 1, 4.4, 3.4)
    scatter(figure, axes[0, 0], found, colour)
    return figure


def scatter(figure: Any, ax: Any, found: Collapse, colour: str) -> None:
    """Every row a dot; the front dashed."""
    from matplotlib.colors import LogNorm

    rows = found.rows[found.rows[colour] > 0]
    values, across = rows[colour], rows[found.against]
    norm = LogNorm(values.min(), max(values.max(), values.min() * 1.01))
    dots = ax.scatter(across, rows["ke_ratio"], c=values, norm=norm, s=5, cmap="viridis", linewidth=0, rasterized=True)
    ax.axhline(1, color="0.6", linewidth=0.6, zorder=0)
    if found.front is not None:
        ends = np.array([found.front.start, found.front.end])
        ratio = found.front.A * ends**found.front.s
        ax.plot(ends, ratio, "--", color="#D55E00", linewidth=1.2, label=f"front: slope {found.front.s:.2f}")
        ax.legend(fontsize=7, frameon=False)
    ax.set(xscale="log", yscale="log", xlabel=AXES[found.against], ylabel="KE ratio")
    style.plain_ticks(ax.yaxis)
    style.bar(figure, dots, ax, style.LABELS[colour])
