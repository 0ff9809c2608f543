"""Boxes of a grid that are halved until what lies in them can be interpolated: which of a map's tasks are computed.

A box spans some axes from one place to another. At its corners and halfway between them the numbers are known; where
those halfway are what the corners let one expect, nothing more in it is computed. Interpolation is linear in the
logarithm of the number and of every axis (in the axis itself where it reaches 0). A place whose number is worth nothing
(chaotic or failed) is left out of it; where so little is left that nothing can be told, the box is not halved.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Box = tuple[tuple[int, int], ...]  # first and last place on every axis
Place = tuple[int, ...]
START_STEP = 8  # places of an axis from one corner of the first boxes to the next
# Halving a step quarters the error of linear interpolation where numbers are smooth; half of that gain is counted on.
# Measured on the paper's figures 4 and 5: 95 to 97 of 100 calm places are then within the error.
HALFWAY = 2.0
WORTHLESS_MAX = 0.5  # share of a box's known places that tell nothing, from which on it is not halved


def scale_of(values: Sequence[float]) -> Array:
    """The coordinates of an axis in which numbers are interpolated."""
    array = np.asarray(values, np.float64)
    return np.log(array) if array.min() > 0 else array


def first_boxes(shape: Sequence[int]) -> list[Box]:
    """The boxes with which a map of this shape begins."""
    sides = []
    for n in shape:
        ends = np.linspace(0, n - 1, -(-(n - 1) // START_STEP) + 1).round().astype(int).tolist() if n > 1 else [0, 0]
        sides.append(list(pairwise(ends)))
    return list(product(*sides))


def corners(box: Box) -> list[Place]:
    """Its corners, each once."""
    return list(dict.fromkeys(product(*box)))


def halves(box: Box) -> list[Box]:
    """The boxes into which it is halved, along every axis that has a place between; itself where none has."""
    return list(product(*([(a, b)] if b - a < 2 else [(a, (a + b) // 2), ((a + b) // 2, b)] for a, b in box)))


def halfway(box: Box) -> list[Place]:
    """The places halfway between its corners; none where the box is as small as can be."""
    there = set(corners(box))
    return [place for place in dict.fromkeys(p for half in halves(box) for p in corners(half)) if place not in there]


def expected(box: Box, place: Place, scales: Sequence[Array], logs: Callable[[Place], float]) -> float:
    """The logarithm at a place in a box, as its corners let one expect; nan where they tell nothing."""
    total, weights = 0.0, 0.0
    for corner in corners(box):
        weight, log = 1.0, logs(corner)
        for (a, b), at, end, scale in zip(box, place, corner, scales, strict=True):
            share = (scale[at] - scale[a]) / (scale[b] - scale[a]) if b > a else 0.0
            weight *= (1.0 - share if end == a else share) if b > a else 1.0
        if weight > 0 and np.isfinite(log):
            total, weights = total + weight * log, weights + weight
    return total / weights if weights > 0 else np.nan


def is_done(box: Box, scales: Sequence[Array], logs: Callable[[Place], float], error: float) -> bool:
    """Whether nothing more of a box is computed, whose corners and places halfway are known."""
    between = halfway(box)
    worthless = [np.isnan(logs(place)) for place in (*corners(box), *between)]
    off = [abs(logs(place) - expected(box, place, scales, logs)) for place in between]
    return not any(x > HALFWAY * error for x in off) or sum(worthless) > WORTHLESS_MAX * len(worthless)


def leaves(
    shape: Sequence[int], scales: Sequence[Array], logs: Callable[[Place], float], error: float
) -> Iterator[Box]:
    """The smallest boxes whose corners are known, where everything is that was asked for: what lies in them follows."""
    boxes = first_boxes(shape)
    while boxes:
        box = boxes.pop()
        parts = halves(box)
        if len(parts) == 1 or is_done(box, scales, logs, error):
            yield from parts
        else:
            boxes += parts
