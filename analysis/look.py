"""How a picture looks: the options that every command has, and matplotlib's settings.

matplotlib is imported only when something is drawn, and figures are made without pyplot: no window, no
backend to choose, nothing global is changed, and the user's own matplotlib settings do not enter.
"""

import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.wrapped import wrapped
from sweep.errors import InputError
from sweep.files import MARK as MARK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe and Ito's colours, apart in every kind of colour vision; the paper's order of curves.
COLOURS = ("#000000", "#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = "osD^vP*X"  # of curves, as many as can be told apart

TITLE_LETTERS = 12  # of the title above a picture, in an inch
PANEL_MIN = 0.5  # inches of a side of a panel: in less nothing is to be read
_SETTINGS: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.linewidth": 0.6,
    "svg.hashsalt": "analysis",  # one table, one file: without it the ids in an SVG are random
}


@dataclass(frozen=True)
class Look:
    """`limits` of the quantity shown, `size` in inches, `dpi` in pixels per inch; None leaves it to the command."""

    limits: tuple[float, float] | None = None
    cmap: str | None = None
    size: tuple[float, float] | None = None
    title: str | None = None
    dpi: int = 200

    def colours(self, n: int) -> Sequence[Any]:
        """Colours for n curves: our own, or n steps of the colour map asked for (or, for many, of viridis)."""
        import matplotlib as mpl

        if self.cmap is None and n <= len(COLOURS):
            return COLOURS[:n]
        cmap = mpl.colormaps[self.cmap or "viridis"]
        return [cmap(0.95 * k / max(n - 1, 1)) for k in range(n)]

    def finish(self, figure: "Figure") -> "Figure":
        """Add the title and lay the figure out; InputError where it does not fit into its size."""
        if self.title is not None:
            figure.suptitle(wrapped(self.title, int(TITLE_LETTERS * figure.get_figwidth())), fontsize=10)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            figure.draw_without_rendering()
        if any("constrained_layout" in str(one.message) for one in caught) or (self.size and _is_cramped(figure)):
            raise too_small(figure)
        return figure

    def set_limits(self, ax: Any) -> None:
        """Limit the vertical axis, which shows the quantity of a picture of curves."""
        if self.limits is not None:
            ax.set_ylim(*self.limits)


PLAIN = Look()


def _is_cramped(figure: "Figure") -> bool:
    """Whether titles reach beyond the picture or into each other, or a panel is a mere strip, once it is laid out."""
    from matplotlib.text import Text

    children = [(ax, one) for ax in figure.axes for one in ax.get_children()]
    panels = [ax.get_window_extent() for ax in figure.axes if ax.get_label() != "<colorbar>"]
    strip = any(min(box.width, box.height) < PANEL_MIN * figure.dpi for box in panels)
    titles = [one for ax, one in children if isinstance(one, Text) and one.get_text() and one not in ax.texts]
    boxes = [one.get_window_extent().padded(-1) for one in titles]  # to a pixel
    inside = all(figure.bbox.fully_contains(*corner) for box in boxes for corner in (box.min, box.max))
    return strip or not inside or any(one.overlaps(other) for one, other in combinations(boxes, 2))


def too_small(figure: "Figure") -> InputError:
    """The error for a size that leaves no room for the picture's text."""
    width, height = figure.get_size_inches()
    return InputError(f"--size: {width:g} x {height:g} inches are too small for this picture")


@contextmanager
def settings() -> Iterator[None]:
    """Within this block matplotlib has its defaults and _SETTINGS; a figure is drawn and saved in one."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def save(figure: "Figure", path: Path, kind: str, dpi: int, mark: str) -> None:
    """Write the figure as "png", "pdf" or "svg", with `mark` where metadata name the program."""
    kinds: dict[str, Any] = {
        "png": {"Software": mark},
        "pdf": {"Creator": mark, "CreationDate": None},
        "svg": {"Creator": [mark], "Date": None},
    }
    whole = io.BytesIO()  # where the disk is full matplotlib would tell of a fault of its own
    with settings():
        figure.savefig(whole, format=kind, dpi=dpi, metadata=kinds[kind])
    path.write_bytes(whole.getbuffer())
