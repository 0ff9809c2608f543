"""The tasks of a sweep, numbered; a task's number is its row in the table. Most sweeps are grids."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sweep.schema import PARAMETERS

Ids = NDArray[np.int64]
Columns = Mapping[str, NDArray[Any]]


class TaskList(Protocol):
    """Some tasks, numbered from 0."""

    def __len__(self) -> int: ...

    def columns(self, ids: Ids) -> dict[str, NDArray[np.generic]]:
        """The parameters of tasks `ids`, one array per name."""

    def find(self, columns: Columns) -> Ids:
        """The numbers of the tasks with these parameters, bit for bit but for -0.0; -1 where there is none."""


class Tasks:
    """All combinations of the axes; the last axis varies fastest. Nothing is stored per task."""

    def __init__(self, axes: Mapping[str, Sequence[float]]) -> None:
        """`axes`: the four parameters, then numbers of the model."""
        self.axes = {name: np.array(axes[name]) for name in inputs(axes)}
        self._shape = tuple(map(len, self.axes.values()))

    def __len__(self) -> int:
        return int(np.prod(self._shape, dtype=np.int64))

    def columns(self, ids: Ids) -> dict[str, NDArray[np.generic]]:
        where = np.unravel_index(ids, self._shape)
        return {name: axis[i] for (name, axis), i in zip(self.axes.items(), where, strict=True)}

    def find(self, columns: Columns) -> Ids:
        places = [_place_on_axis(axis, columns[name]) for name, axis in self.axes.items()]
        there = np.all([place >= 0 for place in places], axis=0)
        ids = np.ravel_multi_index([np.where(there, place, 0) for place in places], self._shape)
        return np.where(there, ids, -1)

    def coarse(self, per_axis: int) -> Ids:
        """The numbers of a grid within the grid: of every axis `per_axis` values at most, both ends among them."""
        few = (np.unique(np.linspace(0, n - 1, min(n, per_axis)).astype(np.int64)) for n in self._shape)
        return self.product(dict(zip(self.axes, few, strict=True)))

    def product(self, places: Mapping[str, Ids]) -> Ids:
        """The numbers of the tasks at these places of the axes, and at all of an axis that is not named; ascending."""
        every = [np.sort(places.get(name, np.arange(len(axis)))) for name, axis in self.axes.items()]
        return np.ravel_multi_index(np.meshgrid(*every, indexing="ij"), self._shape).ravel().astype(np.int64)


class Chosen:
    """Some of the tasks of a grid, in its order: a shard."""

    def __init__(self, grid: TaskList, ids: Ids) -> None:
        """`ids`: numbers in the grid, ascending."""
        self._grid, self._ids = grid, ids

    def __len__(self) -> int:
        return len(self._ids)

    def columns(self, ids: Ids) -> dict[str, NDArray[np.generic]]:
        return self._grid.columns(self._ids[ids])

    def find(self, columns: Columns) -> Ids:
        return _places(self._ids, self._grid.find(columns))


class Listed:
    """Tasks that form no grid, by N, then zeta_T, M_over_M0, V_over_V0, numbers of the model, ordered as of `keys_of`.

    So all of these ascend, but for negative numbers: they come behind the others, the nearest to zero first.
    """

    def __init__(self, keys: NDArray[np.void], names: Sequence[str] = PARAMETERS) -> None:
        """`keys`: one of each task (`keys_of`), in any order, any of them more than once; `names`: their `inputs`."""
        self._keys, self.names = np.unique(keys), tuple(names)

    def __len__(self) -> int:
        return len(self._keys)

    def columns(self, ids: Ids) -> dict[str, NDArray[np.generic]]:
        bits = self._keys[ids].view(">i8").reshape(-1, len(self.names)).astype(np.int64)
        N, *others = np.ascontiguousarray(bits.T)
        return dict(zip(self.names, (N, *(column.view(np.float64) for column in others)), strict=True))

    def find(self, columns: Columns) -> Ids:
        return _places(self._keys, keys_of(columns))

    def coarse(self, per_axis: int) -> Ids:
        """The numbers of as many tasks as `coarse` of a grid of four axes has, from first to last."""
        return np.unique(np.linspace(0, len(self) - 1, per_axis ** len(PARAMETERS)).astype(np.int64))


def inputs(columns: Iterable[str]) -> tuple[str, ...]:
    """The names of columns that say which task it is: the parameters, and the numbers of the model among `columns`."""
    return (*PARAMETERS, *(name for name in columns if name not in PARAMETERS))


def keys_of(columns: Columns) -> NDArray[np.void]:
    """The bits of each task's inputs as one value.

    They are ordered as the numbers are, but a negative number of the model comes behind all others, the further from
    zero the later, as its first bit says its sign. The numbering of tables depends on this order.
    """
    parts = [_bits(np.asarray(columns[name])) for name in inputs(columns)]
    return np.stack(parts, axis=1).astype(">i8").view(f"V{8 * len(parts)}").ravel()


def _bits(values: NDArray[Any]) -> NDArray[np.int64]:
    if values.dtype.kind == "f":
        return np.ascontiguousarray(values + 0.0, np.float64).view(np.int64)  # -0.0 is the task that 0.0 is
    return values.astype(np.int64)


def _place_on_axis(axis: NDArray[Any], wanted: NDArray[Any]) -> Ids:
    order = np.argsort(bits := _bits(axis))
    place = _places(bits[order], _bits(wanted))
    return np.where(place >= 0, order[place], -1)


def _places(ascending: NDArray[Any], wanted: NDArray[Any]) -> Ids:
    """Where each of `wanted` stands in distinct values; -1 where it does not."""
    place = np.minimum(np.searchsorted(ascending, wanted), len(ascending) - 1)
    return np.where(ascending[place] == wanted, place, -1).astype(np.int64)
