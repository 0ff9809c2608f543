"""The picture of the stability atlas: for each plane and method a map of the longest stable step, chaos hatched."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import marks, style
from analysis.atlas import AT, OVER, TARGET, tasks
from analysis.caption import below
from analysis.colours import Scale, bar, plain_scale
from analysis.look import PLAIN, Look, settings
from analysis.notes import hatched_text
from analysis.panel import SYMBOLS, grid, panel, placed, set_axes
from analysis.stability import METHODS, STEP_MAX, STEP_MIN
from analysis.table import unchecked_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIDE = 1.7  # inches, about, of a map
_SIZE = (9.6, 6.6)  # inches
_TAKEN_COLOUR = "#D55E00"
_SAID = (
    "Step: the longest that is stable, in cell transit times (of sound through one cell). explicit: fourth-order "
    "splitting; implicit: leapfrog with implicit dampers; rk45: Dormand-Prince 5(4), its mean step at the loosest "
    "tolerance. "
    f"auto: the choice at a target of {TARGET:g}."
)


def atlas_figure(cells: pd.DataFrame, look: Look = PLAIN) -> "Figure":
    """`cells` is what `analysis.atlas.atlas` returns."""
    with settings():
        figure, axes = style.canvas(len(OVER), len(METHODS), *(look.size or _SIZE))
        steps = cells[[f"step_{method}" for method in METHODS]].to_numpy(np.float64)
        scale = plain_scale(steps, look.limits or (STEP_MIN, STEP_MAX), look.cmap)
        for row, over in enumerate(OVER):
            plane = cells[cells["plane"] == row]
            for ax, method in zip(axes[row], METHODS, strict=True):
                mesh = _map(ax, plane, over, method, scale)
                ax.set_title(f"{method}\n{_fixed(over)}", loc="left", fontsize=8)
        bar(figure, mesh, scale, "longest stable step", ax=axes, pad=0.015, fraction=0.03, aspect=30)
        below(figure, _handles(cells), tuple(SYMBOLS), _SAID, columns=2)
        return look.finish(figure)


def _map(ax: "Axes", plane: pd.DataFrame, over: Sequence[str], method: str, scale: Scale) -> Any:
    on = grid(plane, over)
    drawn = panel(ax, on, plane, f"step_{method}", scale)
    taken = on.matrix(plane.assign(taken=(plane["method"] == method).astype(float)), "taken").eq(1.0).to_numpy()
    for colour, width in (("white", 3.2), (_TAKEN_COLOUR, 1.8)):
        marks.outline(ax, on.across, on.up, taken, colour, width)
    set_axes(ax, on, _SIDE, _SIDE)
    return drawn.mesh


def _fixed(over: Sequence[str]) -> str:
    return placed({name: value for name, value in AT.items() if name not in over})


def _handles(cells: pd.DataFrame) -> list[Any]:
    from matplotlib.lines import Line2D

    taken = Line2D([], [], color=_TAKEN_COLOUR, linewidth=1.8, label="auto takes this method inside")
    unchecked = unchecked_text(cells)
    chaos = hatched_text(cells) + (f"; {unchecked}" if unchecked else "")
    lacking = int(cells[[f"step_{method}" for method in METHODS]].isna().to_numpy().sum())
    short = {f"no number, the step is shorter than {STEP_MIN:.1g}": lacking} if lacking else {}
    return [taken, *marks.handles(short, chaos)]


def rehearse(look: Look) -> "Figure":
    """The picture of a few made-up cells, with all that a legend may hold: a --size too small is refused at once."""
    cells = tasks(2).assign(method=METHODS[0], chaotic=True, checked=True)
    cells = cells.assign(**{f"step_{method}": 1.0 for method in METHODS})
    cells.loc[0, ["checked", "chaotic"]] = False
    cells.loc[1, f"step_{METHODS[0]}"] = np.nan
    return atlas_figure(cells, look)
