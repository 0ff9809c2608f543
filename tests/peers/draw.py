"""The work-precision diagram: error against time per task, a panel per task, a line per solver."""

import math

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from .common import TARGETS, TASKS
from .table import solvers_of

PANELS = "ABCDE"
FLOOR, CEILING = 1e-6, 1.0  # errors beyond are drawn here


def style(names):
    """A colour and a marker per solver; ours are thick and warm, certified runs are left out."""
    warm = iter(("tab:red", "tab:orange", "gold"))
    cold = iter(("navy", "royalblue", "tab:green", "yellowgreen", "tab:purple", "violet", "0.35"))
    markers = iter("osD^v<>ph*")
    drawn = [name for name in names if "certified" not in name]
    return {
        name: {
            "color": next(warm if name.startswith("ours") else cold),
            "marker": next(markers),
            "linewidth": 2.5 if name.startswith("ours") else 1.2,
        }
        for name in drawn
    }


def panel(axes, points, name, styles):
    """One task."""
    for solver, look in styles.items():
        line = [(p.seconds, min(max(p.error, FLOOR), CEILING)) for p in points if p.solver == solver and p.task == name]
        if line:
            axes.loglog(*zip(*line, strict=True), label=solver, markersize=5, **look)
    task = TASKS[name]
    axes.set_title(f"{name}: N={task.N}, M/M0={task.M_over_M0:g}, V/V0={task.V_over_V0:g}, ζ_T={task.zeta_T:g}")
    axes.set(xlabel="seconds per task", ylabel="error of ke_ratio", ylim=(0.7 * FLOOR, 1.4 * CEILING))
    for target in TARGETS:
        axes.axhline(target, color="0.8", linewidth=0.8, zorder=0)
    axes.grid(True, which="major", color="0.93")


def picture(points, path, footer):
    """Write the diagram."""
    names = [name for name in PANELS if any(p.task == name for p in points)]
    styles, columns = style(solvers_of(points)), min(3, len(names) + 1)
    rows = math.ceil((len(names) + 1) / columns)
    figure, grid = plt.subplots(rows, columns, figsize=(5.2 * columns, 4.2 * rows), squeeze=False)
    for axes, name in zip(grid.flat, names, strict=False):
        panel(axes, points, name, styles)
    for axes in grid.flat[len(names) :]:
        axes.set_axis_off()
    handles = {label: h for axes in grid.flat for h, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    grid.flat[len(names)].legend(handles.values(), handles.keys(), loc="center", fontsize=10)
    figure.text(0.5, 0.005, footer, ha="center", fontsize=8)
    figure.tight_layout(rect=(0, 0.02, 1, 1))
    figure.savefig(path, dpi=110)
    plt.close(figure)
