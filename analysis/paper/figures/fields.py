"""Figures 2, 3 and 7: space-time maps of kinetic energy, time upwards, cut at 1e-4."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis import style
from analysis.colours import log_bar
from analysis.paper.recipe import Drawn
from analysis.paper.scenes import Seen

CUT = 1e-4  # of KE/TE, the paper's lower end of the colours
CSV_CELLS = 60  # sites and times of the field that go into the CSV: the picture's own would be 50 MB


def fields(seen: Sequence[Seen], titles: Sequence[str], columns: int) -> Drawn:
    """One panel per scene, with one colour scale and a dashed line at the middle site."""
    from matplotlib.colors import LogNorm

    rows = len(seen) // columns
    figure, axes = style.canvas(rows, columns, 2.6 * columns + 0.9, 2.4 * rows + 0.3, sharey=True)
    highest = max(float(one["ke_field"]["ke"].max()) for one in seen)
    norm = LogNorm(CUT, max(highest, 10 * CUT), clip=True)
    for ax, one in zip(axes.flat, seen, strict=True):
        field, N = one["ke_field"], one.scene.N
        borders = np.append(field["site"], N + 1) - 0.5
        times = np.append(field["t"], 2 * field["t"][-1] - field["t"][-2])
        mesh = ax.pcolormesh(borders, times, field["ke"], norm=norm, cmap="viridis", rasterized=True)
        ax.axvline((N + 1) // 2, color="white", linestyle="--", linewidth=0.8)
        ax.set(ylim=(0, field["t"][-1]))
    style.letter(axes, titles)
    style.outer_labels(axes, "site", "$t/N$")
    log_bar(figure, mesh, "KE/TE of a site", "min", ax=axes)
    return Drawn(figure, pd.concat([_numbers(one) for one in seen], ignore_index=True))


def _numbers(one: Seen) -> pd.DataFrame:
    """The field, thinned to the largest value of each block of sites and times, which keeps the pulses."""
    field = one["ke_field"]
    t, site = (np.unique(np.linspace(0, n, CSV_CELLS + 1).astype(int))[:-1] for n in field["ke"].shape)
    ke = np.maximum.reduceat(np.maximum.reduceat(field["ke"], t, axis=0), site, axis=1)
    event = one.scene.event
    columns = {"t": np.repeat(field["t"][t], len(site)), "site": np.tile(field["site"][site], len(t)), "ke": ke.ravel()}
    fixed = {"N": one.scene.N, "law": one.scene.law, "zeta_T": one.scene.zeta_T, **vars(event)}
    return pd.DataFrame(columns).assign(**fixed)
