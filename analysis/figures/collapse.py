"""Scatter plots of ke_ratio against a dimensionless number (figures 4d, 13, 14)."""

from typing import Any

import numpy as np
import pandas as pd

from analysis.figures import style
from kernel.model import M0, V0

AXES = {
    "Pi_IE": r"$\Pi_{I-E} = M V^2$",
    "Pi_IV": r"$\Pi_{I-V} = M V / 2\zeta_T$",
    "N_over_zeta_T": r"$N/\zeta_T$",
}


def numbers(df: pd.DataFrame) -> pd.DataFrame:
    """The rows with Pi_IE, Pi_IV and N_over_zeta_T beside them; infinite without damping."""
    M, V = df["M_over_M0"] * M0, df["V_over_V0"] * V0
    with np.errstate(divide="ignore"):
        viscous = M * V / (2 * df["zeta_T"]), df["N"] / df["zeta_T"]
    return df.assign(Pi_IE=M * V**2, Pi_IV=viscous[0], N_over_zeta_T=viscous[1])


def scatter(figure: Any, ax: Any, df: pd.DataFrame, across: str, colour: str) -> None:
    """Every row a dot, coloured by a logarithmic scale; rows without damping are off a logarithmic axis."""
    from matplotlib.colors import LogNorm

    rows = numbers(df)
    rows = rows[np.isfinite(rows[across]) & (rows["ke_ratio"] > 0)]
    values = rows[colour]
    norm = LogNorm(values.min(), max(values.max(), values.min() * 1.01))
    dots = ax.scatter(
        rows[across], rows["ke_ratio"], c=values, norm=norm, s=5, cmap="viridis", linewidth=0, rasterized=True
    )
    ax.axhline(1, color="0.6", linewidth=0.6, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel=AXES[across], ylabel="KE ratio")
    style.plain_ticks(ax.yaxis)
    style.bar(figure, dots, ax, style.LABELS[colour])
