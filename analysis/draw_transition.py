"""The picture of N_transition against zeta_T, with power laws (figure 6b)."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.caption import MEANINGS, below, sentence
from analysis.colours import shade_bar, shades
from analysis.look import MARKERS, PLAIN, Look, settings
from analysis.notes import none_text, skipped_text
from analysis.paper.numbers import HIGH_DAMPING
from analysis.power_law import power_law
from analysis.quantity import KE, Quantity
from analysis.ruler import ruler
from analysis.table import IMPACT, unchecked_words
from analysis.ticks import label, ticks
from sweep.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEGEND_MAX = 7  # impacts that each have a colour of their own and a line of the legend; more are coloured by speed
# Of the smallest step between two zeta_T: the markers of many impacts stand side by side over it, each less than a
# quarter of the way to the next zeta_T.
_SPREAD_SHARE = 0.4
_MARKER_MAX, _MARKER_MIN = 4.5, 1.5  # points
_LINE = 0.9  # points
_AXIS_SHARE = 0.7  # of the picture's width, about
_AXIS_SHARES = np.array([_AXIS_SHARE, 0.4])  # of its width and height
_MARGINS = 1.1  # what an axis spans over what is drawn on it
_SHORT = 100.0  # between the ends of an axis of zeta_T: on shorter ones matplotlib's many numbers overlap
_SAID = "Bars: the $N$ that it lies between."
_SPREAD = "Markers of one $\\zeta_T$ stand side by side about it (grey lines)."
_EXPONENT = ": $b$ = "  # in the legend of an impact that has a power law
_LEGEND = "Legend: $(M/M_0, V/V_0)$."
_LAWS = (
    r"Dashed: $A\,\zeta_T^{-b}$ by weighted least squares through the transitions up to "
    rf"$\zeta_T$ = {HIGH_DAMPING:g}, where four or more have one; in brackets the 95 % interval of $b$."
)


def transition_figure(
    found: pd.DataFrame,
    look: Look = PLAIN,
    chain: str = "",
    of: Quantity = KE,
    within: tuple[float, float] | None = None,
) -> "Figure":
    """`found` is what `analysis.transition` gives; bars are N_low and N_high. chain: what is said of it.

    within: the least and the largest N of the table, for the axis where nothing is drawn.
    """
    if not (found["zeta_T"] > 0).any():
        raise InputError("N_transition is drawn against zeta_T above 0, and there is zeta_T = 0 only")
    with settings():
        figure, axes = style.canvas(1, 1, *(look.size or (5.6, 5.0)))
        ax = axes[0, 0]
        there = found[found["N_transition"].notna()]
        impacts = [(key, rows) for key, rows in there[there["zeta_T"] > 0].groupby(IMPACT)]
        none = " ".join(filter(None, (none_text(found, "transition"), _undamped(int((there["zeta_T"] == 0).sum())))))
        if not impacts:
            _empty(ax, found, within, none)
        elif len(impacts) <= LEGEND_MAX:
            colours, n = look.colours(len(impacts)), len(impacts)
            for k, ((M, V), rows) in enumerate(impacts):
                curve(ax, rows, f"({M:.3g}, {V:.3g})", colours[k], MARKERS[k], **style.nested(k, n))
        else:
            shifts = _shifts(found, len(impacts))
            _many(figure, ax, impacts, shifts, _size(impacts, shifts, figure, look), look)
        look.set_limits(ax)
        finish(ax)
        shown = there if impacts else found
        _label_short(ax, np.unique(shown.loc[shown["zeta_T"] > 0, "zeta_T"]), figure.get_figwidth())
        handles, texts = ax.get_legend_handles_labels()
        many = len(impacts) > LEGEND_MAX
        legend = _LEGEND if impacts and not many else ""
        laws = _LAWS if legend and any(_EXPONENT in text for text in texts) else ""
        apart = _SPREAD if many else style.NESTED if len(impacts) > 1 else ""
        said = (_SAID, skipped_text(found, "transition"), apart, none) if impacts else ()
        massless = many and len({M for (M, _), _ in impacts}) > len(MARKERS)
        unchecked = sentence(unchecked_words(int(found["unchecked"].sum()), int(found["rows"].sum())))
        about = MEANINGS["N_transition"].replace(KE.title, of.title)
        names = (about, of.meaning, "N", "zeta_T", *(() if massless else ("M_over_M0",)), "V_over_V0")
        below(figure, handles, names, chain, *said, legend, laws, unchecked, columns=2)
        return look.finish(figure)


def curve(
    ax: Any,
    rows: pd.DataFrame,
    text: str | None,
    colour: Any,
    marker: str = "o",
    paper: float | None = None,
    shift: float = 1.0,
    **marks: Any,
) -> None:
    """Draw the transitions of one impact and, where there is one, its power law, with the paper's exponent in the text.

    The markers, that look as `marks` tell, stand at `shift` times their zeta_T. Without a text there is no law either.
    """
    own = {"markersize": _MARKER_MAX, "mew": 0, "linewidth": _LINE} | marks
    damped = rows[rows["zeta_T"] > 0]
    bars = np.abs(damped[["N_low", "N_high"]].to_numpy().T - damped["N_transition"].to_numpy())
    line = {"color": colour, "linewidth": _LINE}
    ax.errorbar(damped["zeta_T"] * shift, damped["N_transition"], bars, fmt=marker, color=colour, **own)
    law = None if text is None else power_law(damped)
    if law and text is not None:
        text += f"{_EXPONENT}{exponent(law.b)} ({exponent(law.low)} to {exponent(law.high)})"
        text += f", paper {paper}" if paper else ""
        ends = np.array([law.start, law.end])
        ax.plot(ends, law.A * ends**-law.b, "--", **line)
    if text is not None:
        ax.plot([], [], f"{marker}--" if law else marker, label=text, **line, mfc=marks.get("mfc"))


def exponent(b: float) -> str:
    """An exponent with three decimals; zero has no minus."""
    return f"{round(b, 3) + 0.0:.3f}"


def finish(ax: Any) -> None:
    """Set the scales and labels of the axes."""
    ax.set(xscale="log", yscale="log", xlabel=style.LABELS["zeta_T"], ylabel=r"$N_\mathrm{transition}$")
    style.plain_ticks(ax.yaxis)


def _undamped(count: int) -> str:
    """That transitions are not drawn because a logarithmic axis has no place for their zeta_T; empty without any."""
    are = "transition at $\\zeta_T$ = 0 is" if count == 1 else "transitions at $\\zeta_T$ = 0 are"
    return f"{count} {are} not drawn." if count else ""


def _label_short(ax: Any, zeta_T: "np.ndarray[tuple[int], np.dtype[np.float64]]", width: float) -> None:
    """Label the values of zeta_T where the axis is so short that matplotlib's numbers between them would overlap."""
    low, high = ax.get_xlim()
    if high <= _SHORT * low:
        found = ticks(ruler(zeta_T), _AXIS_SHARE * width, across=True)
        ax.set_xticks(found.places, found.labels)
        ax.set_xticks([], minor=True)


def _empty(ax: Any, found: pd.DataFrame, within: tuple[float, float] | None, text: str) -> None:
    """Axes over the ranges of the table, and the reason why nothing is on them."""
    zeta_T = found.loc[found["zeta_T"] > 0, "zeta_T"]
    ax.set_xlim(*style.span(zeta_T.min(), zeta_T.max()))
    if within is not None:
        ax.set_ylim(*style.span(*within))
    style.say_empty(ax, text)


def _shifts(found: pd.DataFrame, n: int) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    """Factors by which the markers of n impacts are moved sideways."""
    zetas = np.unique(found.loc[found["zeta_T"] > 0, "zeta_T"])
    step = float(np.diff(np.log(zetas)).min()) if len(zetas) > 1 else 0.2
    return np.exp(_SPREAD_SHARE * step * (np.arange(n) - (n - 1) / 2) / max(n, 1))


def _size(impacts: Any, shifts: Any, figure: Any, look: Look) -> float:
    """The size of a marker, in points, that touches no other, be it beside it or above."""
    from scipy.spatial import KDTree

    moved = [rows.assign(at=rows["zeta_T"] * shift) for (_, rows), shift in zip(impacts, shifts, strict=True)]
    drawn = pd.concat(moved)
    low, high = look.limits or (drawn["N_low"].min(), drawn["N_high"].max())
    spans = np.log([drawn["at"].max() / drawn["at"].min(), high / low]) * _MARGINS
    points = 72 * _AXIS_SHARES * figure.get_size_inches() / spans * np.log(drawn[["at", "N_transition"]])
    apart = float(KDTree(points).query(points, k=2, p=np.inf)[0][:, 1].min())
    return float(np.clip(0.8 * apart, _MARKER_MIN, _MARKER_MAX))


def _many(figure: Any, ax: Any, impacts: Any, shifts: Any, size: float, look: Look) -> None:
    """Draw many impacts: the colour is the speed, the marker the mass if there are few masses."""
    speeds = [V for (_, V), _ in impacts]
    masses = sorted({M for (M, _), _ in impacts})
    scale = shades(speeds, look.cmap)
    few = len(masses) <= len(MARKERS)
    for ((M, V), rows), shift in zip(impacts, shifts, strict=True):
        marker = MARKERS[masses.index(M)] if few else "."
        curve(ax, rows, None, scale.to_rgba(V), marker, shift=shift, markersize=size)
    for zeta_T in np.unique(np.concatenate([rows["zeta_T"] for _, rows in impacts])):
        if zeta_T > 0:
            ax.axvline(zeta_T, color="0.85", linewidth=0.6, zorder=0)
    for M, marker in zip(masses if few else [], MARKERS, strict=False):
        ax.plot([], [], marker, color="0.4", markersize=4, label=f"{style.LABELS['M_over_M0']} = {label(M)}")
    shade_bar(figure, ax, scale, speeds, style.LABELS["V_over_V0"])
