"""The picture of work against precision: a line per method, ode45's defaults as a star."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis import tradeoff
from analysis.caption import below
from analysis.look import PLAIN, Look, settings
from analysis.quantity import KE
from analysis.style import plain_ticks
from analysis.tradeoff import CERTIFIED, RK45, UNCERTIFIED, cost_of_a_digit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Colours of Okabe and Ito, apart in every kind of colour vision; markers and dashes tell the same in grey.
STYLES: dict[str, dict[str, Any]] = {
    CERTIFIED: {"color": "#0072B2", "marker": "o"},
    UNCERTIFIED: {"color": "#56B4E9", "marker": "s"},
    RK45: {"color": "#D55E00", "marker": "^"},
}
WORK = {"ms_50": "time per task (ms)", "evaluations_per_time_50": "force evaluations per cell transit time"}
_SAID = (
    "auto: the method and step are chosen for a target error; "
    "rk45: Dormand-Prince 5(4). The number beside a point of a solid line is its target (auto) or rtol (rk45)."
)
# Two neighbours share a label if they differ by less than these factors; times are measured, and noisy.
_SAME_WORK, _SAME_ERROR = 1.6, 1.15
# Where else a label may stand beside its point, in points of the page, the nearest first; then half a marker's size.
_PLACES: list[dict[str, Any]] = [
    {"position": (x * far, y * far), "ha": ("center", "left", "right")[x], "va": "center"}
    for far in (7, 13, 19)
    for x in (1, -1, 0)
    for y in (1, -1, 0)
    if x or y
]
_MARKER = 2.5


def tradeoff_figure(
    points: pd.DataFrame, tasks: int, look: Look = PLAIN, source: str = "random tasks of the paper's domain"
) -> "Figure":
    """Error against time per task and against force evaluations, medians over `tasks` tasks."""
    from matplotlib.figure import Figure

    with settings():
        figure = Figure(figsize=look.size or (7.4, 5.0), layout="constrained")
        axes = figure.subplots(1, 2, sharey=True)
        styles = _styles(look)
        for ax, letter, (work, words) in zip(axes, "ab", WORK.items(), strict=True):
            _panel(ax, points, work, styles)
            ax.set(xscale="log", yscale="log", xlabel=f"{words}, median")
            ax.set_title(f"({letter})", loc="left")
            ax.grid(which="major", color="0.88", linewidth=0.5)
            ax.set_axisbelow(True)
            ax.margins(x=0.22)
        look.set_limits(axes[0])
        for ax in axes:
            plain_ticks(ax.xaxis)
        axes[0].set_ylabel(f"relative error of the {KE.title}, {tasks} tasks")
        _name_costs(axes[0], points)
        below(figure, _handles(styles), (KE.ratio,), f"Well-conditioned {source}. {_SAID}", columns=3)
        look.finish(figure)
        for ax in axes:
            _part_names(ax)
        return figure


def _styles(look: Look) -> dict[str, dict[str, Any]]:
    if look.cmap is None:
        return STYLES
    return {
        name: style | {"color": colour} for (name, style), colour in zip(STYLES.items(), look.colours(3), strict=True)
    }


def _panel(ax: "Axes", points: pd.DataFrame, work: str, styles: dict[str, dict[str, Any]]) -> None:
    for name, line in points.groupby("method", sort=False):
        style = styles[str(name)]
        ax.plot(line[work], _seen(line["error_90"]), linewidth=1.4, markersize=4.5, **style)
        ax.plot(line[work], _seen(line["error_50"]), "--", linewidth=0.8, markersize=3.5, mfc="white", **style)
        _name_points(ax, line, work, name != UNCERTIFIED, style["color"])
    for quantile, face in (("error_90", "black"), ("error_50", "white")):
        star = points[points["ode45_defaults"]]
        ax.plot(star[work], _seen(star[quantile]), "*", color="black", mfc=face, markersize=11, zorder=4)


def _seen(error: "pd.Series[float]") -> "pd.Series[float]":
    """The errors that a logarithmic axis can show: neither zero nor infinite."""
    return error.where(np.isfinite(error) & (error > 0))


def _name_points(ax: "Axes", line: pd.DataFrame, work: str, right: bool, colour: Any) -> None:
    """Write the target or rtol beside each point of a solid line, in its colour.

    The texts of points that coincide stand one above the other, since there is little room beside a line's first point.
    """
    from matplotlib.patheffects import withStroke

    for x, y, texts in _labelled(line[[work, "error_90", "setting"]].to_numpy(dtype=np.float64)):
        side: dict[str, Any] = {"xytext": (6, 3), "ha": "left"} if right else {"xytext": (-4, -10), "ha": "right"}
        if len(texts) > 1:
            side = {"xytext": (2, 8), "ha": "right"} if right else {"xytext": (-6, 0), "ha": "right", "va": "center"}
        note = ax.annotate("\n".join(texts), (x, y), textcoords="offset points", fontsize=7, color=colour, **side)
        note.set_path_effects([withStroke(linewidth=2, foreground="white")])


def _part_names(ax: "Axes") -> None:
    """Move each label to where it covers no other one and stands nearest to its own point of its line, then to where it
    covers the fewest points.
    """
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

    # The points of the dashed lines, and the lines themselves, may be covered: there are too many.
    solid = [line for line in ax.lines if line.get_linestyle() != "--"]
    points = {line: ax.transData.transform(np.asarray(line.get_xydata())) for line in solid}
    size = _MARKER * ax.figure.dpi / 72
    marks = [Bbox([at - size, at + size]) for at in np.concatenate([*points.values()]) if np.isfinite(at).all()]
    taken = [text.get_window_extent() for text in ax.texts if not isinstance(text, Annotation)]

    def covered(note: Annotation, place: dict[str, Any]) -> tuple[int, int]:
        note.set(**place)
        box = note.get_window_extent()
        outside = sum(not ax.bbox.contains(*corner) for corner in (box.min, box.max))
        middle, own = np.mean([box.min, box.max], axis=0), ax.transData.transform(note.xy)
        line = np.concatenate([points[line] for line in solid if line.get_color() == note.get_color()])
        nearer = np.hypot(*(line - middle).T) < np.hypot(*(own - middle)) - size  # not those that share the label
        return box.count_overlaps(taken) + outside + int(nearer.sum()), box.count_overlaps(marks)

    for note in ax.findobj(Annotation):
        own: dict[str, Any] = {"ha": note.get_horizontalalignment(), "va": note.get_verticalalignment()}
        own["position"] = note.get_position()
        note.set(**min([own, *_PLACES], key=lambda place: covered(note, place)))
        taken.append(note.get_window_extent())


def _labelled(points: NDArray[np.float64]) -> list[tuple[float, float, list[str]]]:
    """The place and the lines of every label, for points (n, 3) of work, error and setting."""
    shown: list[tuple[float, float, list[str]]] = []
    last = (0.0, 0.0)
    for x, y, setting in points.tolist():
        text = f"$10^{{{round(np.log10(setting))}}}$"
        if not (np.isfinite(y) and y > 0):
            continue
        if last[0] / _SAME_WORK < x < last[0] * _SAME_WORK and last[1] / _SAME_ERROR < y < last[1] * _SAME_ERROR:
            shown[-1][2].append(text)
        else:
            shown.append((x, y, [text]))
        last = (x, y)
    return shown


def _name_costs(ax: "Axes", points: pd.DataFrame) -> None:
    costs = {name: cost_of_a_digit(points[points["method"] == name])[0] for name in (CERTIFIED, RK45)}
    text = "\n".join(f"{name.partition(',')[0]}: {cost:.1f} times the time" for name, cost in costs.items())
    box = {"boxstyle": "round", "facecolor": "white", "edgecolor": "0.7", "linewidth": 0.5}
    ax.text(0.03, 0.04, f"a tenth of the error costs\n{text}", transform=ax.transAxes, fontsize=7.5, bbox=box, zorder=5)


def _handles(styles: dict[str, dict[str, Any]]) -> list[Any]:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], linewidth=1.4, markersize=4.5, label=name, **style) for name, style in styles.items()]
    star: dict[str, Any] = {"linestyle": "", "color": "black", "marker": "*", "markersize": 10}
    handles.append(Line2D([], [], label="ode45's defaults (rk45, $10^{-3}$)", **star))
    for text, (dash, width) in {"90 % of the tasks are better": ("-", 1.4), "50 % are better": ("--", 0.8)}.items():
        grey: dict[str, Any] = {"color": "0.3", "linestyle": dash, "linewidth": width}
        handles.append(Line2D([], [], label=text, **grey))
    return handles


def rehearse(tasks: int, look: Look) -> "Figure":
    """The picture of made-up points on straight lines: a --size too small is refused at once."""
    return tradeoff_figure(pd.DataFrame([_made_up(setting) for setting in tradeoff.settings()]), tasks, look)


def _made_up(one: tradeoff.Setting) -> dict[str, Any]:
    errors = {"error_50": one.setting / 2, "error_90": one.setting}
    work = dict.fromkeys(("ms_50", "ms_mean", "evaluations_per_time_50"), one.setting**-0.25)
    return {"method": one.method, "setting": one.setting, "ode45_defaults": one.ode45} | errors | work
