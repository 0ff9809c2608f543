"""What lies between the computed places of a map, and where that is not known well enough.

Between places goes a thin-plate spline through the nearest computed ones, of the logarithm of the number over those of
the axes (over the axis itself where it reaches 0). How good it is, each computed place tells by being left out: how far
what the others let one expect is off there. A place whose number is worth nothing (chaotic or failed) is left out of
the spline; where most of the places around are such, nothing more is computed, and where all are, nothing is told.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ids = NDArray[np.int64]
# FIRST_STEP, ROUGH, THROUGH, AROUND and OFF as python -m tests.map_constants fits them, on the paper's figures 4 and 5
# and five maps besides (its --planes).
FIRST_STEP = 8  # values of an axis from one place of the first lattice to the next
# Share of the places that are computed where screening shows them rough: without, nothing showed on one map that 6 % of
# the screened places were off; with half or twice of it, the same.
ROUGH = 0.01
THROUGH = 24  # places through which the spline goes: fewer say less, more take time
AROUND = 4  # places around one that tell how far the spline is off there, and whether numbers are worth anything
# How often `error` the spline may be off around a place one mean step of the axes from the nearest computed one: it is
# off about there as far as where a place is left out, whose neighbours are further.
OFF = 1.6
WORTHLESS_MAX = 0.5  # most: share of the places around that tell nothing, beyond which a place is not asked for
SLACK = 1e-9  # of the spline's slopes, over its bending: where places lie on a line it has none across
AT_ONCE = 128  # splines solved together: with more, getting their memory takes as long as solving them


def coordinates(axes: Sequence[Sequence[float]]) -> Array:
    """Where every place of a map lies, (places, axes): the last axis varies fastest, its mean step is 1."""
    scales = []
    for values in axes:
        array = np.asarray(values, np.float64)
        scale = np.log(array) if array.min() > 0 else array
        scales.append((scale - scale[0]) * ((len(scale) - 1) / max(scale[-1] - scale[0], np.finfo(float).tiny)))
    return np.stack([each.ravel() for each in np.meshgrid(*scales, indexing="ij")], axis=1)


def first_places(shape: Sequence[int]) -> Ids:
    """The places with which a map of this shape begins: a lattice with both ends of every axis."""
    ends = (np.unique(np.linspace(0, n - 1, -(-(n - 1) // FIRST_STEP) + 1).round().astype(np.int64)) for n in shape)
    places = np.ravel_multi_index(np.meshgrid(*ends, indexing="ij"), tuple(shape))
    return np.asarray(places.ravel(), np.int64)


def rough_places(logs: Array, computed: Flags) -> Ids:
    """A share ROUGH of the other places, denser where the map is rough: equal roughness lies between neighbours.

    logs: logarithms of what screening gave, in the shape of the map. The roughness of a place is how far its value lies
    from the mean of its two neighbours, along the axis where that is most.
    """
    rough = np.zeros(logs.shape)
    for axis in range(logs.ndim):
        along, found = np.moveaxis(logs, axis, 0), np.moveaxis(rough, axis, 0)
        found[1:-1] = np.fmax(found[1:-1], np.abs(along[1:-1] - (along[:-2] + along[2:]) / 2.0))
    others = np.flatnonzero(~computed)
    until = np.cumsum(rough.ravel()[others])
    if not len(until) or until[-1] == 0.0:
        return others[:0]
    count = max(1, round(ROUGH * logs.size))
    chosen = np.unique(until.searchsorted((np.arange(count) + 0.5) / count * until[-1]))
    return np.asarray(others[chosen], np.int64)


def interpolated(at: Array, logs: Array, computed: Flags) -> Array:
    """The logarithm at every place (n,) from those at the computed ones; nan where they tell nothing.

    at: the coordinates (n, axes); logs: (n,), nan where a number is worth nothing.
    """
    found, known = np.full(len(at), np.nan), computed & np.isfinite(logs)
    if known.any():
        told = np.flatnonzero(known[computed][_nearest(at[computed], at, AROUND)[1]].any(axis=1))
        distance, near = _nearest(at[known], at[told], THROUGH)
        found[told] = _spline(at[known], logs[known], at[told], near, distance)
    return found


def wanted(at: Array, logs: Array, computed: Flags, error: float, most: int) -> Ids:
    """Which places are to be computed next, ascending: `most`, where the spline is off furthest, none near another."""
    known, others = computed & np.isfinite(logs), np.flatnonzero(~computed)
    if known.sum() < 2 or not len(others):
        return others[:0]
    distance, near = _nearest(at[computed], at[others], AROUND)
    told, step = np.mean(~known[computed][near], axis=1) <= WORTHLESS_MAX, distance[:, 0]
    if not known[computed].all():
        others, step = others[told], step[told]
        distance, near = _nearest(at[known], at[others], AROUND)
    weight = distance**-2.0
    off = (left_out(at[known], logs[known])[near] * weight).sum(axis=1) / weight.sum(axis=1)
    first = np.argsort(-off * step, kind="stable")[: np.count_nonzero(off * step > OFF * error)]
    return np.sort(others[first[_apart(at[others[first]], step[first], most)]])


def left_out(at: Array, logs: Array) -> Array:
    """How far the spline through the others is off at each of some places."""
    distance, near = _nearest(at, at, THROUGH + 1)
    return np.abs(_spline(at, logs, at, near[:, 1:], distance[:, 1:]) - logs)


def _nearest(at: Array, asked: Array, count: int) -> tuple[Array, Ids]:
    """Distance and number of the nearest of some places, (asked, count or as many as there are), ascending."""
    from scipy.spatial import cKDTree  # only rank 0 asks

    distance, near = cKDTree(at).query(asked, range(1, min(count, len(at)) + 1))
    return distance, near


def _apart(at: Array, step: Array, most: int) -> Ids:
    """The first `most` of some places, none of them as near to one before as this one is to what is computed."""
    from scipy.spatial import cKDTree

    free, chosen, tree = np.ones(len(at), np.bool_), list[int](), cKDTree(at)
    for k in range(len(at)):
        if free[k] and len(chosen) < most:
            free[tree.query_ball_point(at[k], step[k])] = False
            chosen.append(k)
    return np.array(chosen, np.int64)


def _spline(at: Array, logs: Array, asked: Array, near: Ids, distance: Array) -> Array:
    """The thin-plate spline through the `near` places, at the asked ones."""
    found = np.empty(len(asked))
    for first in range(0, len(asked), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        unit = np.maximum(distance[part, -1:, None], np.finfo(float).tiny)
        x = (at[near[part]] - asked[part, None]) / unit
        found[part] = np.einsum("ij,ij->i", _weights(x), logs[near[part]])
    return found


def _weights(x: Array) -> Array:
    """What the number at each place x (splines, places, axes) counts for the spline at 0."""
    count, n, axes = x.shape
    system = np.zeros((count, n + 1 + axes, n + 1 + axes))
    turned, squared = np.swapaxes(x, 1, 2), (x**2).sum(axis=2)
    system[:, :n, :n] = _bending(squared[:, :, None] + squared[:, None] - 2 * x @ turned)
    system[:, :n, n] = system[:, n, :n] = 1.0
    system[:, :n, n + 1 :], system[:, n + 1 :, :n] = x, turned
    slopes = range(n, n + 1 + axes)
    system[:, slopes, slopes] = -SLACK
    right = np.zeros((count, n + 1 + axes, 1))
    right[:, :n, 0], right[:, n] = _bending(squared), 1.0
    return np.asarray(np.linalg.solve(system, right)[:, :n, 0])


def _bending(squared: Array) -> Array:
    """r^2 log r, twice, of r^2."""
    return np.asarray(squared * np.log(squared, out=np.zeros_like(squared), where=squared > 0))
