"""A table that may still be growing: read again when the file has changed, and no more often than it pays."""

import threading
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.chain import made_of
from analysis.commands.common import rows_of
from analysis.page import part_on_page
from analysis.reading import TORN_LABEL
from analysis.searched import spec_of
from analysis.table import DONE_LABEL
from kernel.task import is_input
from sweep.errors import InputError

REST = 5.0  # a reading is followed by a rest of so many times its duration
PATIENCE = 5.0  # seconds for which a table may be unreadable before that is told: somebody may be writing it


@dataclass(frozen=True)
class Seen:
    """A table as it was read, with all that a page shows of it."""

    rows: pd.DataFrame
    part: str = ""  # what it is a part of
    made: str = ""  # its chain, and how its rows were computed
    asked: tuple[Any, ...] = ()  # of its spec: what every row depends on beside its inputs
    number: int = 1  # of the table: another one where it is no longer the same, grown

    @property
    def version(self) -> str:
        """Differs where what the page shows does: a row that is done stays as it is."""
        counts = self.rows["status"].value_counts()
        told = ", ".join(sorted(f"{n} {label}" for label, n in counts.items() if n))
        return f"table {self.number}: {told}. {self.part}".strip()


class Growing:
    """The table at `path`, whenever it is asked for; several threads may ask.

    Raises
    ------
    InputError
        Where there is no table to read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._stamp: tuple[int, ...] | None = None
        self._next: float  # when it may be read again, once it was
        self._seen = Seen(pd.DataFrame())
        self._since, self._problem = 0.0, ""  # when it was read or as it is for the last time, and why it is not now
        self.now()

    def now(self) -> Seen:
        """The table as it is now, or was a moment ago."""
        with self._lock:
            stamp = self._stamp_now()
            if stamp is not None and stamp == self._stamp:
                self._well()
            elif self._stamp is None or time.monotonic() >= self._next:
                self._read(stamp)
            return self._seen

    def problem(self) -> str:
        """Why the table cannot be read, for longer than it takes to write one; empty where it can."""
        return self._problem if time.monotonic() - self._since >= PATIENCE else ""

    def _read(self, stamp: tuple[int, ...] | None) -> None:
        start = time.monotonic()
        try:
            seen = _seen(self.path, self._seen)
            self._seen, self._stamp = seen, stamp
            self._well()
        except (InputError, OSError) as error:  # somebody may be writing it; at the next look it may be whole
            if self._stamp is None:
                raise
            self._problem = str(error)
        self._next = time.monotonic() + REST * (time.monotonic() - start)

    def _well(self) -> None:
        self._since, self._problem = time.monotonic(), ""

    def _stamp_now(self) -> tuple[int, ...] | None:
        try:
            found = self.path.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino


def _seen(path: Path, before: Seen) -> Seen:
    rows, spec = rows_of(path), spec_of(path)
    part, asked = " ".join(part_on_page(path, rows).values()), (spec.get("model"), spec.get("accuracy"))
    seen = Seen(rows, part, made_of(path, rows), asked, before.number)
    same = before.rows.empty or _is_same(before, seen)
    return seen if same else replace(seen, number=before.number + 1)


def _is_same(old: Seen, new: Seen) -> bool:
    """Whether a table is the one before, with more of it computed: all inputs, and all done rows, are as they were."""
    if old.asked != new.asked or list(old.rows.columns) != list(new.rows.columns):
        return False
    if not old.rows.index.isin(new.rows.index).all():
        return False
    was, now = old.rows, new.rows.loc[old.rows.index]
    whole = ~(was["status"].isin((TORN_LABEL, "")) | now["status"].isin((TORN_LABEL, ""))).to_numpy()
    done = whole & (was["status"] == DONE_LABEL).to_numpy()
    return all(_alike(was[name], now[name], whole if is_input(name) else done) for name in was.columns)


def _alike(one: "pd.Series[Any]", other: "pd.Series[Any]", rows: NDArray[np.bool_]) -> bool:
    """Whether some rows of two columns are equal; what is not known is equal to itself."""
    if one.dtype.kind in "biuf" and other.dtype.kind in "biuf":
        a, b = (column.to_numpy(float, na_value=np.nan)[rows] for column in (one, other))
        return np.array_equal(a, b, equal_nan=True)
    return bool((one.astype(str).to_numpy()[rows] == other.astype(str).to_numpy()[rows]).all())
