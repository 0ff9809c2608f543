"""Saves the rows of a damaged table: they lie side by side, each with its parameters and its checksum."""

import filecmp
import mmap
import os
import shutil
from collections import Counter
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError, writing
from sweep.log import say
from sweep.plan.tasks import Ids, TaskList
from sweep.schema import LAYOUTS, PARAMETERS, ROW, blank_of, is_ended
from sweep.store import table
from sweep.store.unwritten import probes

Rows = tuple[Ids, NDArray[np.void]]  # finished rows and their numbers
COPIED_AT_ONCE = 1 << 24  # bytes
ALIKE_MAX = 1000  # rows that begin alike
KEY_BYTES = max(ROW.fields[name][1] + ROW[name].itemsize for name in PARAMETERS)  # type: ignore[index]


def rescued(path: Path, tasks: TaskList, identity: tuple[str, ...], layout: np.dtype[Any]) -> Rows | None:
    """The rows of a damaged table (`salvage`), which is kept as TABLE.damaged; None where the table is not damaged."""
    try:
        with table.reading(path) as file:
            table.attributes(file)
        return None
    except InputError:  # it may not even look like a table
        if not path.is_file():  # opening a pipe would wait for ever
            raise
        ids, rows = salvage(path, tasks, identity, layout)
    aside = path.with_name(f"{path.name}.damaged")
    _keep(path, aside)
    say(f"{path}: is damaged; {len(ids)} of {len(tasks)} rows are saved, the damaged file is kept as {aside}")
    return ids, rows


def _keep(path: Path, aside: Path) -> None:
    """Give the damaged file a second name; InputError where another file has it."""
    try:
        os.link(path, aside)
    except OSError:
        if not os.path.lexists(aside):  # a disk on which a file has one name only, as exFAT, CIFS and FUSE
            with path.open("rb") as file:
                copied(file, aside)
        elif not (aside.is_file() and filecmp.cmp(path, aside, shallow=False)):  # alike: a repair was interrupted
            raise InputError(f"{aside}: is there already, from an earlier repair; move it away") from None


def copied(file: BinaryIO, aside: Path) -> None:
    """Copy a file of which nothing else is left once this returns: on the disk, and whole if it has its name."""
    partial = aside.with_name(f".{aside.name}.partial")
    with writing(aside):
        try:
            with partial.open("wb") as copy:
                shutil.copyfileobj(file, copy, COPIED_AT_ONCE)
                copy.flush()
                os.fsync(copy.fileno())
            partial.rename(aside)
        finally:
            partial.unlink(missing_ok=True)


def salvage(path: Path, tasks: TaskList, identity: tuple[str, ...], layout: np.dtype[Any]) -> Rows:
    """The intact finished rows of `path`, found without HDF5, and their task ids.

    `identity`: texts of kernel and accuracy. Where the file lacks one, its rows may be others, and none is kept.
    InputError where there is no trace of this sweep in the file.
    """
    nothing = np.empty(0, np.int64), np.empty(0, layout)
    with path.open("rb") as file:
        data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if path.stat().st_size else b""
    first = _first_row(data, tasks, layout.itemsize)
    if first is None:
        if not any(data.find(name.encode()) >= 0 for name in LAYOUTS):
            raise InputError(f"{path}: holds no trace of this sweep; delete it, or give another -o")
        return nothing
    if not all(data.find(text.encode()) >= 0 for text in identity):
        return nothing
    size = layout.itemsize
    skipped = max(0, -(first // size))
    start = first + skipped * size
    count = min(len(tasks) - skipped, (len(data) - start) // size)
    rows = np.frombuffer(data[start : start + count * size], layout)
    ids = np.arange(skipped, skipped + count)
    right = is_ended(rows)
    for name, values in tasks.columns(ids).items():
        right &= rows[name] == values
    return ids[right], rows[right]


def _first_row(data: mmap.mmap | bytes, tasks: TaskList, row_size: int) -> int | None:
    """The offset of row 0 in bytes, as most of the tasks looked for say; None where none was found."""
    ids = probes(len(tasks))
    columns = tasks.columns(ids)
    rows = blank_of({name: columns[name] for name in PARAMETERS})  # with which every layout begins
    votes: Counter[int] = Counter()
    for row_id, row in zip(ids.tolist(), rows, strict=True):
        # Tasks that differ in numbers of the model alone begin alike: each of their rows may be the one looked for.
        key, found = row.tobytes()[:KEY_BYTES], -1
        for _ in range(ALIKE_MAX):
            if (found := data.find(key, found + 1)) == -1:
                break
            votes[found - row_id * row_size] += 1
    return votes.most_common(1)[0][0] if votes else None
