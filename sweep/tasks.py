"""The tasks of a sweep: the grid's combinations, numbered; a task's number is its row in the table."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from kernel import Task
from sweep.schema import PARAMETERS

Ids = NDArray[np.int64]


class Tasks:
    """All combinations of the four axes, the last axis varying fastest. Nothing is stored per task."""

    def __init__(self, axes: Mapping[str, Sequence[float]]) -> None:
        self._axes = [np.array(axes[name]) for name in PARAMETERS]
        self._shape = tuple(len(axis) for axis in self._axes)

    def __len__(self) -> int:
        return int(np.prod(self._shape, dtype=np.int64))

    def columns(self, ids: Ids) -> dict[str, NDArray[np.generic]]:
        """The parameters of tasks `ids`, one array per name."""
        where = np.unravel_index(ids, self._shape)
        return {name: axis[i] for name, axis, i in zip(PARAMETERS, self._axes, where, strict=True)}

    def task(self, task_id: int) -> Task:
        """One task, ready for the kernel."""
        where = np.unravel_index(task_id, self._shape)
        N, zeta_T, M, V = (axis[i].item() for axis, i in zip(self._axes, where, strict=True))
        return Task(N, zeta_T, M, V)
