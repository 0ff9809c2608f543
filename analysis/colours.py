"""The colours of a map, and the bar beside it that explains them.

A ratio has two colours that meet at 1: blue where the chain passes on less than when made linear, red where
more. Any other column has one row of colours. Both are logarithmic, can be told apart in every kind of colour vision,
and hold no grey, which means "no number".
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.ruler import RELATIVE_MATCH
from analysis.ticks import beside, label, linear, scale_ticks

if TYPE_CHECKING:
    from matplotlib.colors import Colormap, Normalize

RATIO_CMAP, PLAIN_CMAP = "RdYlBu_r", "viridis"
EQUAL = 1.0  # the ratio of two chains that do the same
_SIDE_SPAN = 10.0  # factor that each side of the scale spans at least, so that small differences do not look large
_BESIDE = {"pad": 0.015, "fraction": 0.046, "aspect": 25}  # how a bar stands beside its axes
_TICKS_MIN = 3  # fewer numbers beside a bar do not tell its scale
_VALUES_MAX = 6  # a scale of so many values or fewer is labelled with each of them

Array = NDArray[np.float64]
Limits = tuple[float, float]


@dataclass(frozen=True)
class Scale:
    """How numbers become colours, and what stands beside the bar."""

    norm: "Normalize"
    cmap: "Colormap"
    ticks: list[float]
    shown: Limits  # the part of the scale that the bar shows
    extend: str = "neither"

    def labelled(self, inches: float) -> list[float]:
        """The numbers beside a bar of so many inches; where some have no room, round ones in their place."""
        low, high = self.shown
        ticks, rounds = (
            [tick for tick in some if low <= tick <= high]
            for some in (self.ticks, scale_ticks(low, high) if low > 0 else self.ticks)
        )
        every = np.array([low, high, *ticks, *rounds])
        places = np.asarray(self.norm(every))  # all at once: a norm takes as long for one number as for many
        shares = dict(zip(every.tolist(), ((places - places[0]) / (places[1] - places[0])).tolist(), strict=True))
        return beside([ticks, rounds], shares.__getitem__, inches, EQUAL if EQUAL in rounds else low)


def ratio_scale(values: Array, limits: Limits | None = None, cmap: str | None = None) -> Scale:
    """The colours of a ratio (any shape, nan where unknown): their middle is 1, and each side spans its own range.

    Without `limits` the colours reach from the lowest to the highest value, and at least a decade to either side of 1;
    the bar shows the part that occurs. Limits on one side of 1 take the colours of that side only.
    """
    from matplotlib import colormaps
    from matplotlib.colors import FuncNorm, ListedColormap, LogNorm

    found = values[np.isfinite(values) & (values > 0)]
    data = (float(found.min()), float(found.max())) if len(found) else (EQUAL, EQUAL)
    colours = colormaps[cmap or RATIO_CMAP]
    low, high = limits or (min(data[0], EQUAL / _SIDE_SPAN), max(data[1], EQUAL * _SIDE_SPAN))
    shown = limits or (min(data[0], EQUAL), max(data[1], EQUAL))
    if shown[0] == shown[1]:
        shown = (low, high)
    if not low < EQUAL < high:
        half = np.linspace(0, 0.5, 128) if high <= EQUAL else np.linspace(0.5, 1, 128)
        return Scale(
            LogNorm(low, high), ListedColormap(colours(half)), scale_ticks(low, high), shown, _extend(data, low, high)
        )
    below, above = -np.log(low), np.log(high)

    def share(ratio: Any) -> Any:
        logs = np.ma.log(np.ma.masked_less_equal(ratio, 0))  # nothing is drawn where a value is masked
        return logs / np.ma.masked_array(np.where(logs < 0, below, above))

    def ratio(share: Any) -> Any:
        return np.exp(np.where(np.asarray(share) < 0, share * below, share * above))

    ticks = sorted({*scale_ticks(low, EQUAL), EQUAL, *scale_ticks(EQUAL, high)})
    if sum(shown[0] <= tick <= shown[1] for tick in ticks) < _TICKS_MIN:  # all ratios are near 1
        ticks = [tick for tick in scale_ticks(*shown) if float(f"{tick:.3g}") == tick]  # as `label` writes it
    return Scale(FuncNorm((share, ratio), low, high), colours, ticks, shown, _extend(data, low, high))


def plain_scale(values: Array, limits: Limits | None = None, cmap: str | None = None) -> Scale:
    """For any other column: from the lowest to the highest of `values`, logarithmic where all are positive."""
    from matplotlib import colormaps
    from matplotlib.colors import LogNorm, Normalize

    found = np.unique(values[np.isfinite(values)])
    data = (float(found[0]), float(found[-1])) if len(found) else limits or (0.0, 1.0)
    low, high = limits or data
    colours = colormaps[cmap or PLAIN_CMAP]
    extend = _extend(data, low, high)
    if low <= 0:
        high = high if high > low else low + 1
        return Scale(Normalize(low, high), colours, linear(low, high), (low, high), extend)
    low, high = (low, high) if high > low else (low / 2, high * 2)
    few = found.tolist() if len(found) <= _VALUES_MAX else scale_ticks(low, high)
    return Scale(LogNorm(low, high), colours, few, (low, high), extend)


def shades(values: Any, cmap: str | None = None, log: bool = True) -> Any:
    """The colours of curves or dots: of their numbers from the lowest to the highest, or to 1 % above a single one."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    low, high = (float(np.min(values)), float(np.max(values))) if len(values) else (1.0, 2.0)
    return ScalarMappable((LogNorm if log else Normalize)(low, max(high, 1.01 * low)), cmap or PLAIN_CMAP)


def shade_bar(figure: Any, ax: Any, scale: Any, values: Any, text: str) -> None:
    """The bar of `shades`; of a single value, which has no range, an entry of the legend in its place."""
    low, high = np.min(values), np.max(values)
    if high > low:
        log_bar(figure, scale, text, ax=ax)
    else:
        ax.plot([], [], "o", color=scale.to_rgba(low), markersize=3, label=f"{text} = {label(float(low))}")


def bar(figure: Any, mesh: Any, scale: Scale, text: str, **place: Any) -> None:
    """The colour bar, `place` as matplotlib's (ax, or cax), with plain numbers beside it."""
    from matplotlib.ticker import FuncFormatter

    found = figure.colorbar(mesh, extend=scale.extend, **(place if "cax" in place else _BESIDE | place))
    found.ax.set_ylim(*scale.shown)
    found.set_ticks(_fitting(found.ax, scale))
    found.formatter = FuncFormatter(lambda tick, _: label(tick))
    found.minorticks_off()
    found.set_label(text)


def _fitting(ax: Any, scale: Scale) -> Any:
    """The ticks of a bar on these axes, chosen when it is drawn: only then it has its height."""
    from matplotlib.ticker import Locator

    class Fitting(Locator):
        def __call__(self) -> list[float]:
            return scale.labelled(float(ax.bbox.height / ax.figure.dpi))

    return Fitting()


def log_bar(figure: Any, mesh: Any, text: str, extend: str = "neither", **place: Any) -> None:
    """The same for a mesh that already has a logarithmic scale."""
    low, high = mesh.get_clim()
    bar(figure, mesh, Scale(mesh.norm, mesh.cmap, scale_ticks(low, high), (low, high), extend), text, **place)


def _extend(data: Limits, low: float, high: float) -> str:
    below, above = data[0] < low * (1 - RELATIVE_MATCH), data[1] > high * (1 + RELATIVE_MATCH)
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")
