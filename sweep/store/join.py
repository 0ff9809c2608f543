"""Rows of one table put into another, task by task: what `sweep merge` and `sweep run --reuse` share."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from kernel.jit import source_hash
from sweep.errors import InputError
from sweep.plan.tasks import Ids, TaskList
from sweep.schema import DONE, PARAMETERS, RESULTS, ROW, RUN_COLUMNS, is_ended, text_of
from sweep.store import table

RAISED = b"error"  # the status of a task that raised an exception, which can be the machine's fault
CONTENT = [name for name in ROW.names or () if name not in RUN_COLUMNS]
TOLD_MAX = 5  # disagreeing tasks that are told one by one


class DisagreementError(Exception):
    """Two tables give one task different numbers."""

    def __init__(self, there: NDArray[np.void], rows: NDArray[np.void], ids: Ids) -> None:
        super().__init__(f"{len(rows)} tasks")
        self.there, self.rows, self.ids = there, rows, ids

    def lines(self) -> list[str]:
        """The task, and each column that differs with both values; the first few tasks."""
        told = [_told(*pair) for pair in zip(self.there[:TOLD_MAX], self.rows[:TOLD_MAX], strict=True)]
        more = len(self.rows) - len(told)
        return [*told, f"and {more} more tasks"] if more else told


def put_rows(target: h5py.File, tasks: TaskList, rows: NDArray[np.void]) -> Ids:
    """Write finished `rows` where `target` has none for the task; the numbers of the tasks written.

    A row of a task that raised gives way to any other. Raises DisagreementError where others differ in what must agree.
    """
    ids = tasks.find({name: rows[name] for name in PARAMETERS})
    order = np.argsort(ids, kind="stable")
    order = order[ids[order] >= 0]
    ids, rows = ids[order], rows[order]
    if not len(ids):
        return ids
    there = table.read_rows(target[RESULTS], ids)
    known = is_ended(there)
    better = known & (there["status"] == RAISED) & (rows["status"] != RAISED)
    differ = known & ~better & (rows["status"] != RAISED) & (_bits(there) != _bits(rows))
    if differ.any():
        raise DisagreementError(there[differ], rows[differ], ids[differ])
    new = ~known | better
    written: Ids = ids[new]
    if len(written):
        table.write_rows(target[RESULTS], written, rows[new])
    return written


def reusable(olds: Sequence[Path], accuracy: Mapping[str, Any]) -> None:
    """InputError, naming every problem, unless the rows of `olds` are what this sweep would compute."""
    problems: list[str] = []
    for old in olds:
        try:
            with table.reading(old) as file:
                theirs, kernels = accuracy_of(file), table.kernels(file)
        except InputError as error:
            problems += error.problems
            continue
        if differ := sorted(key for key in {*theirs, *accuracy} if theirs.get(key) != accuracy.get(key)):
            problems.append(f"--reuse {old}: was computed with another accuracy (it differs in {', '.join(differ)})")
        if kernels != {source_hash()}:
            problems.append(f"--reuse {old}: was computed by another version of the kernel")
    if problems:
        raise InputError(*problems)


def accuracy_of(file: h5py.File) -> dict[str, Any]:
    """The section [accuracy] of a table's spec; InputError where it is damaged."""
    try:
        return dict(table.resolved(file)["accuracy"])
    except KeyError:
        raise InputError(f"{file.filename}: its provenance does not tell how accurate it is") from None


def reuse(path: Path, tasks: TaskList, old: Path) -> int:
    """Put the done rows of `old` into the table at `path`; how many it did not have."""
    count = 0
    try:
        with table.reading(old) as source, h5py.File(path, "r+") as target:
            for rows in table.finished_rows(source):
                count += len(put_rows(target, tasks, rows[rows["status"] == DONE]))
    except DisagreementError as error:
        raise InputError(*(f"--reuse {old}: {path} disagrees: {line}" for line in error.lines())) from None
    except OSError as error:  # open in another program, or the disk is full
        raise InputError(f"{path}: cannot be written: {' '.join(str(error).split())}") from None
    return count


def _bits(rows: NDArray[np.void]) -> NDArray[np.void]:
    """What must agree, as one value per row."""
    packed = np.empty(len(rows), [(name, ROW[name]) for name in CONTENT])
    for name in CONTENT:
        packed[name] = rows[name]
    return packed.view(f"V{packed.dtype.itemsize}")


def _told(there: np.void, row: np.void) -> str:
    task = ", ".join(f"{name} {row[name]}" for name in PARAMETERS)
    columns = [name for name in CONTENT if there[name].tobytes() != row[name].tobytes()]
    return f"task {task}: {', '.join(f'{name} {_plain(there[name])} or {_plain(row[name])}' for name in columns)}"


def _plain(value: Any) -> str:
    return text_of(value) if isinstance(value, bytes) else str(value)
