"""What a picture holds, as lines of text: its words and where they stand, its curves, cells, colours and scales."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

KEPT = Path(__file__).parent / "data" / "pictures.json"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# Numbers that differ by less are the same: processors differ in their last digits, and these in how they are rounded.
PARTS = re.compile(r"(\[[-\d ]*\])")
NEAR = 1e-3  # of a number
NEAR_PARTS = 1  # of what is told in thousandths, of a picture's width or of the largest number
ZERO = 1e-9
SHOWN = 20  # differences that are told of one picture


@contextmanager
def sketched() -> Iterator[dict[str, list[str]]]:
    """The lines of every picture that is written meanwhile, and of its numbers, by the picture's stem."""
    from analysis import look, output

    found, save = dict[str, list[str]](), output.save

    def saved(figure: Any, path: Path, *how: Any) -> None:
        with look.settings():
            figure.draw_without_rendering()
            found[path.name.removeprefix(".").partition(".")[0]] = sketch(figure)
        save(figure, path, *how)

    output.save = saved
    try:
        yield found
    finally:
        output.save = save


def sketch(figure: Any) -> list[str]:
    """Lines of what can be seen of a figure that has been laid out."""
    size = figure.get_size_inches() * figure.dpi
    lines = [f"picture {_list(figure.get_size_inches())} inches"]
    lines += [_text(text, size) for text in figure.texts if text.get_text()]
    lines += [line for legend in figure.legends for line in _legend(legend, size)]
    for ax in figure.axes:
        lines.append(f"axes at {_box(ax, size)} {ax.get_xscale()} {ax.get_yscale()} {_list(ax.axis())}")
        lines += [_text(text, size) for text in (ax.title, ax.xaxis.label, ax.yaxis.label) if text.get_text()]
        for axis in (ax.xaxis, ax.yaxis):
            ticks = [text.get_text() for text in axis.get_ticklabels() if text.get_visible() and text.get_text()]
            lines += [f"ticks {ticks} {_number(axis.get_ticklabels()[0].get_rotation())}"] if ticks else []
        drawn = [child for child in ax.get_children() if child not in (ax.patch, *ax.spines.values())]
        lines += [line for child in drawn for line in _artist(child, size)]
        lines += _legend(ax.get_legend(), size) if ax.get_legend() else []
    return lines


def _artist(artist: Any, size: Any) -> list[str]:
    from matplotlib.collections import Collection
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.text import Text

    if not artist.get_visible():
        return []
    match artist:
        case Text() if artist.get_text():
            return [_text(artist, size)]
        case Line2D():
            look = f"{artist.get_linestyle()} {artist.get_marker()} {_colour(artist.get_color())}"
            return [f"line {_name(artist)} {look} {_data(artist.get_xdata())} {_data(artist.get_ydata())}"]
        case Collection():
            where = artist.get_offsets() if len(artist.get_offsets()) > 1 else _corners(artist)
            look = f"hatch {artist.get_hatch()} {_colour(artist.get_facecolor())} {_colour(artist.get_edgecolor())}"
            values = "" if artist.get_array() is None else f" {_data(artist.get_array())} {_list(artist.get_clim())}"
            return [f"{type(artist).__name__} {_name(artist)} {look} {_data(where)}{values}"]
        case Patch():
            where = artist.get_path().transformed(artist.get_patch_transform()).vertices
            look = f"hatch {artist.get_hatch()} {_colour(artist.get_facecolor())} {_colour(artist.get_edgecolor())}"
            return [f"{type(artist).__name__} {_name(artist)} {look} {_data(where)}"]
    return []


def _corners(collection: Any) -> Any:
    paths = collection.get_paths()
    return np.concatenate([path.vertices for path in paths]) if len(paths) else np.zeros(0)


def _legend(legend: Any, size: Any) -> list[str]:
    handles = [line for handle in legend.legend_handles for line in _artist(handle, size)]
    return [f"legend at {_box(legend, size)} {[text.get_text() for text in legend.get_texts()]}", *handles]


def _text(text: Any, size: Any) -> str:
    return f"text {text.get_text()!r} at {_box(text, size)} {_colour(text.get_color())} {_number(text.get_rotation())}"


def _box(artist: Any, size: Any) -> str:
    return _thousandths(artist.get_window_extent().get_points() / size)


def _name(artist: Any) -> str:
    label = str(artist.get_label())
    return "" if label.startswith("_") else repr(label)


def _colour(colour: Any) -> str:
    from matplotlib.colors import to_rgba_array

    return _data(to_rgba_array(colour))


def _data(values: Any) -> str:
    """How many numbers, their largest size, and in parts of it the least, the mean, and the mean weighted by place."""
    try:
        array = np.ma.filled(np.ma.asarray(values, float), np.nan).ravel()
    except (TypeError, ValueError):  # names of categories
        return str(list(values))
    known = array[np.isfinite(array)]
    scale = np.abs(known).max() if known.size else 0.0
    if not scale:
        return f"({array.size}: 0)"
    parts = known / scale
    weighted = (parts * np.linspace(0, 1, parts.size)).mean()
    size = f"{array.size}" if array.size == known.size else f"{known.size} of {array.size}"
    return f"({size}: {_number(scale)} * {_thousandths([parts.min(), parts.mean(), weighted])})"


def _list(values: Any) -> str:
    return " ".join(map(_number, np.ravel(values)))


def _thousandths(values: Any) -> str:
    return "[" + " ".join(f"{1e3 * value:.0f}" for value in np.ravel(values)) + "]"


def _number(value: float) -> str:
    return f"{value:.5g}"


def told_of_numbers(frame: pd.DataFrame) -> list[str]:
    """Lines of a table: each column's name, and its numbers or words."""
    return [
        f"column {name} {_data(column) if pd.api.types.is_numeric_dtype(column) else sorted(set(map(str, column)))}"
        for name, column in frame.items()
    ]


def differences(kept: list[str], now: list[str]) -> list[str]:
    """What of a picture is other than it was kept: numbers that differ by more than NEAR, and all else."""
    found = [f"{len(now)} lines for {len(kept)}"] if len(kept) != len(now) else []
    found += [f"was {old}\nis  {new}" for old, new in zip(kept, now, strict=False) if not _alike(old, new)]
    return found[:SHOWN]


def _alike(old: str, new: str) -> bool:
    if NUMBER.sub("", old) != NUMBER.sub("", new):
        return False
    for was, now in zip(PARTS.split(old), PARTS.split(new), strict=True):
        near = 0.0 if was.startswith("[") else NEAR
        for a, b in zip(map(float, NUMBER.findall(was)), map(float, NUMBER.findall(now)), strict=True):
            if abs(a - b) > (near * max(abs(a), abs(b)) + ZERO if near else NEAR_PARTS):
                return False
    return True


def assert_kept(sketches: dict[str, list[str]], room: str) -> None:
    """Every picture of a room holds what it held when it was last looked at."""
    kept = json.loads(KEPT.read_text())[room]
    assert sorted(sketches) == sorted(kept)
    differ = {name: different for name in kept if (different := differences(kept[name], sketches[name]))}
    told = "\n".join(line for name, lines in differ.items() for line in (f"{name}:", *lines))
    assert not differ, f"{told}\nIf this is meant: python -m tests.pictures --keep, and look at the pictures."
