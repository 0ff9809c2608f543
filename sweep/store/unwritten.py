"""The rows of a large table that nobody has written yet: room on the disk, all zero, that is read as pending rows.

To write 1e8 rows keeps a disk busy for minutes, and they say nothing that the grid does not say. Where a table's rows
alone tell its tasks (of a list, a shard or a search) all are written when it is created.
"""

import errno
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.plan.tasks import Tasks
from sweep.schema import PENDING, RESULTS, blank_of
from sweep.store import disk
from sweep.store.structure import place

ROWS_WRITTEN_MAX = 1 << 22  # 0.7 GB, which a disk takes in seconds
PROBES = 64  # rows that are written in any case: by them `sweep run --repair` finds where in a damaged file rows lie


def is_unwritten(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows are as the new table had them: no task has N = 0."""
    return np.asarray((rows["N"] == 0) & (rows["checksum"] == 0))


def grid_of(known: Mapping[str, str], rows: int) -> Tasks | None:
    """The tasks of a table of so many rows where it is large and its provenance tells them all; None of any other."""
    if rows <= ROWS_WRITTEN_MAX or "shard" in known:
        return None
    from sweep.plan.spec import read_axes  # pydantic, which the workers of a run do without

    try:
        resolved = json.loads(known["resolved"])
        if {"search", "adaptive"} & set(resolved):
            return None
        grid = Tasks(read_axes(resolved["grid"]))
    except (KeyError, TypeError, ValueError):
        return None
    return grid if len(grid) == rows else None


def pending(parameters: Mapping[str, NDArray[Any]], layout: np.dtype[Any]) -> NDArray[np.void]:
    """Rows of tasks with these parameters, each (n,), that are to be computed."""
    rows = blank_of(parameters, layout)
    rows["status"] = PENDING
    return rows


def filled_in(grid: Tasks, rows: NDArray[np.void], first: int) -> NDArray[np.void]:
    """These rows, from number `first` on, with what the unwritten ones stand for."""
    places = np.flatnonzero(is_unwritten(rows))
    if len(places):
        rows[places] = pending(grid.columns(first + places), rows.dtype)
    return rows


def probes(count: int) -> NDArray[np.int64]:
    """The numbers of the rows that are written in any case, first and last among them."""
    return np.unique(np.linspace(0, count - 1, PROBES).astype(np.int64))


class Sparse:
    """Reads a large table's rows past what nobody has written, as far as the file system tells."""

    def __init__(self, file: h5py.File) -> None:
        results, path = file[RESULTS], Path(file.filename)
        self._first, self._layout = place(results)[0], results.dtype
        # Other nodes' file systems may know better than this one's what was written.
        self.serves = len(results) > ROWS_WRITTEN_MAX and not disk.is_shared(path)
        self._descriptor = os.open(path, os.O_RDONLY) if self.serves else -1
        if self.serves:  # what is read ahead counts as written from then on
            os.posix_fadvise(self._descriptor, 0, 0, os.POSIX_FADV_RANDOM)

    def __enter__(self) -> "Sparse":
        return self

    def __exit__(self, *_: object) -> None:
        if self.serves:
            os.close(self._descriptor)

    def read(self, part: slice) -> NDArray[np.void] | None:
        """These rows, zero where nothing was written; None where nothing was written at all."""
        size = self._layout.itemsize
        first, end = self._first + part.start * size, self._first + part.stop * size
        rows, at = None, first
        while at < end and (start := self._seek(at, os.SEEK_DATA, end)) < end:
            at = self._seek(start, os.SEEK_HOLE, end)
            rows = np.zeros(part.stop - part.start, self._layout) if rows is None else rows
            there: Any = rows.view(np.uint8)[start - first : at - first]
            self._read_into(memoryview(there), start)
        return rows

    def _seek(self, at: int, whence: int, end: int) -> int:
        try:
            return min(os.lseek(self._descriptor, at, whence), end)
        except OSError as error:
            if error.errno == errno.ENXIO and at < os.fstat(self._descriptor).st_size:  # there is nothing more
                return end
            raise

    def _read_into(self, there: memoryview, at: int) -> None:
        while there:
            if not (count := os.preadv(self._descriptor, [there], at)):
                raise OSError(errno.EIO, "the file is cut off")
            there, at = there[count:], at + count
