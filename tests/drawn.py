"""Small tables for the tests of pictures, and what can be read off a figure."""

import itertools

import numpy as np
import pandas as pd

FOUR = ["N", "zeta_T", "M_over_M0", "V_over_V0"]


def frame(grid, **columns):
    """Finished, checked rows of a grid (N, zeta_T, M_over_M0, V_over_V0); ke_ratio falls from above 1 with N."""
    df = pd.DataFrame(list(itertools.product(*grid)), columns=FOUR)
    ratio = 20 / df["N"] * (1 + 0.1 * df["M_over_M0"]) * (1 + 0.01 * df["V_over_V0"])
    rest = {"ke_ratio": ratio, "error": 1e-4, "chaotic": False, "checked": True, "status": "done"}
    return df.assign(**rest).assign(**columns).astype({"chaotic": "boolean"})


def written(figure):
    """All texts of a figure, joined, without the line breaks of the small print."""
    from matplotlib.text import Text

    return " ".join(text.get_text() for text in figure.findobj(Text)).replace("\n", " ")


def legend(figure):
    """The labels of the figure's legend."""
    return [text.get_text().replace("\n", " ") for one in figure.legends for text in one.get_texts()]


def hatched(ax):
    """How many cells carry the hatching, by its colours."""
    marked = [one for one in ax.collections if one.get_hatch()]
    return {tuple(one.get_edgecolor()[0]): len(one.get_paths()) for one in marked}


def mesh(ax):
    """The coloured cells."""
    from matplotlib.collections import QuadMesh

    return next(one for one in ax.collections if isinstance(one, QuadMesh))


def stars(ax):
    """Where the stars are."""
    return [tuple(map(float, line.get_xydata()[0])) for line in ax.get_lines() if line.get_marker() == "*"]


def colour_of(ax, value):
    """RGBA of a value on a map."""
    return np.array(mesh(ax).to_rgba(np.array([value]))[0])


def assert_nested(ax):
    """Each curve's marks fit into those drawn before, so do its bars, and all can be looked through."""
    drawn = [container.lines for container in ax.containers]
    assert all(line.get_markerfacecolor() == "none" for line, *_ in drawn)
    sizes = [line.get_markersize() - line.get_markeredgewidth() for line, *_ in drawn]
    widths = [bars.get_linewidth()[0] for _, _, (bars,) in drawn]
    assert (np.diff(sizes) < -1).all()
    assert (np.diff(widths) < -0.5).all()  # points


def crowded(figure):
    """The texts that reach beyond the figure's edge, or run into another: pairs; to a pixel, as it would be saved."""
    from matplotlib.axis import Axis
    from matplotlib.text import Text

    figure.draw_without_rendering()
    hidden = {text for axis in figure.findobj(Axis) for text in _out_of_sight(axis)}
    seen = [one for one in figure.findobj(Text) if one.get_visible() and one.get_text().strip() and one not in hidden]
    boxes = [(one.get_text(), one.get_window_extent()) for one in seen]
    cut = [(text, "edge") for text, box in boxes if not _inside(box, figure.bbox)]
    pairs = itertools.combinations(boxes, 2)
    return cut + [(one, other) for (one, box), (other, there) in pairs if box.padded(-1).overlaps(there.padded(-1))]


def _inside(box, outer):
    return outer.x0 - 1 <= box.x0 and box.x1 <= outer.x1 + 1 and outer.y0 - 1 <= box.y0 and box.y1 <= outer.y1 + 1


def _out_of_sight(axis):
    """The labels of ticks beyond the ends of an axis: matplotlib keeps them, and draws none."""
    low, high = sorted(axis.get_view_interval())
    for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
        if not low - 1e-9 * abs(low) <= tick.get_loc() <= high + 1e-9 * abs(high):
            yield from (tick.label1, tick.label2)
