"""The options --limits, --cmap, --size, --title and --dpi, checked together before anything is computed."""

import argparse
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from analysis.look import Look
from kernel.hints import did_you_mean
from sweep.errors import InputError

_SIDE_LIMITS = (1.0, 40.0)  # inches: from a stamp to a poster
_PIXELS_MAX = (500 * _SIDE_LIMITS[1]) ** 2  # 1.6 GB of memory: the poster at 500 pixels per inch
_DPI_LIMITS = (30, 2400)  # pixels per inch: from a thumbnail to fine print


def look(args: argparse.Namespace) -> Look:
    """What the options say; InputError with one line for each that is not possible."""
    checks: dict[str, Callable[[str], Any]] = {
        "limits": _limits,
        "cmap": _cmap,
        "size": _size,
        "title": _title,
        "dpi": _dpi,
    }
    found, problems = dict[str, Any](), list[str]()
    for name, check in checks.items():
        text = getattr(args, name)
        try:
            found |= {} if text is None else {name: check(text)}
        except ValueError as error:
            problems.append(f"--{name}: {error}, got {text!r}")
    if problems:
        raise InputError(*problems)
    wanted = Look(**found)
    if wanted.size and Path(args.output).suffix.lower() == ".png":
        _refuse_pixels(*wanted.size, wanted.dpi)
    return wanted


def _refuse_pixels(width: float, height: float, dpi: int) -> None:
    """InputError for a picture of points that would not fit the memory, or the program that is to show it."""
    if (pixels := width * height * dpi**2) > _PIXELS_MAX:
        many = f"{width * dpi:.0f} x {height * dpi:.0f} pixels"
        rule = f"must give at most {_PIXELS_MAX:.0e} pixels, or a .pdf, which has none"
        raise InputError(f"--size, --dpi: {rule}, got {many} ({pixels:.1e})")


def _pair(text: str, rule: str) -> tuple[float, float]:
    try:
        low, high = map(float, text.split(","))
    except ValueError:
        raise ValueError(rule) from None
    return low, high


def _limits(text: str) -> tuple[float, float]:
    rule = "must be two positive numbers LOW,HIGH with LOW below HIGH"
    low, high = _pair(text, rule)
    if not 0 < low < high < math.inf:
        raise ValueError(rule)
    return low, high


def _size(text: str) -> tuple[float, float]:
    rule = f"must be W,H in inches, each from {_SIDE_LIMITS[0]:g} to {_SIDE_LIMITS[1]:g}"
    width, height = _pair(text, rule)
    if not all(_SIDE_LIMITS[0] <= side <= _SIDE_LIMITS[1] for side in (width, height)):
        raise ValueError(rule)
    return width, height


def _dpi(text: str) -> int:
    if not (text.isdecimal() and _DPI_LIMITS[0] <= int(text) <= _DPI_LIMITS[1]):
        raise ValueError(f"must be a whole number from {_DPI_LIMITS[0]} to {_DPI_LIMITS[1]}")
    return int(text)


def _cmap(text: str) -> str:
    from matplotlib import colormaps

    if text not in colormaps:
        hint = did_you_mean(text, colormaps)
        raise ValueError(f"must be a colour map of matplotlib, such as viridis or RdYlBu_r{hint}")
    return text


def _title(text: str) -> str:
    from matplotlib.mathtext import MathTextParser

    try:  # what the locale does not know comes as single bytes
        text = text if text.isprintable() else os.fsencode(text).decode()
    except UnicodeError:
        raise ValueError("must be text in UTF-8") from None
    try:
        MathTextParser("path").parse(text)
    except ValueError:
        raise ValueError("what stands between two $ must be a formula that matplotlib can set (write \\$)") from None
    return text
