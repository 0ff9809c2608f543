"""Which rows of one table another one lacks: what `sweep merge` and `sweep run --reuse` share."""

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.plan.tasks import Ids, TaskList
from sweep.schema import RAISED, RESULTS, content_columns, content_of, inputs_of, is_ended, text_of
from sweep.store import table

TASKS_SHOWN_MAX = 5  # of those that disagree: enough to see what differs


class DisagreementError(Exception):
    """Two tables give one task different numbers."""

    def __init__(self, there: NDArray[np.void], rows: NDArray[np.void], ids: Ids) -> None:
        super().__init__(f"{len(rows)} tasks")
        self.there, self.rows, self.ids = there, rows, ids

    def lines(self) -> list[str]:
        """One line for each of the first few tasks, with both values of every column that differs."""
        shown = [_both(*pair) for pair in zip(self.there[:TASKS_SHOWN_MAX], self.rows[:TASKS_SHOWN_MAX], strict=True)]
        more = len(self.rows) - len(shown)
        return [*shown, f"and {more} more tasks"] if more else shown


def lacking(
    target: h5py.File, tasks: TaskList, rows: NDArray[np.void], must_agree: bool = True
) -> tuple[Ids, NDArray[np.void]]:
    """Those of finished `rows` for whose task `target` has none, and the tasks' numbers.

    A row whose task raised an exception gives way to any other row. Where two other rows of a task differ, this raises
    DisagreementError if they `must_agree`; otherwise, as they were computed differently, the row of `target` stays.
    """
    ids = tasks.find({name: rows[name] for name in inputs_of(rows.dtype)})
    order = np.argsort(ids, kind="stable")
    order = order[ids[order] >= 0]
    ids, rows = ids[order], rows[order]
    if not len(ids):
        return ids, rows
    there = table.read_rows(target[RESULTS], ids)
    known = is_ended(there)
    better = known & (there["status"] == RAISED) & (rows["status"] != RAISED)
    differ = known & ~better & (rows["status"] != RAISED) & (content_of(there) != content_of(rows))
    if must_agree and differ.any():
        raise DisagreementError(there[differ], rows[differ], ids[differ])
    new = ~known | better
    return ids[new], rows[new]


def _both(there: np.void, row: np.void) -> str:
    task = ", ".join(f"{name} {row[name]}" for name in inputs_of(row.dtype))
    columns = [name for name in content_columns(row.dtype) if there[name].tobytes() != row[name].tobytes()]
    return f"task {task}: {', '.join(f'{name} {_plain(there[name])} or {_plain(row[name])}' for name in columns)}"


def _plain(value: Any) -> str:
    return text_of(value) if isinstance(value, bytes) else str(value)
