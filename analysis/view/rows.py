"""A table that may still be growing: its rows, read again when the file has changed, and no more often than it pays."""

import threading
import time
from pathlib import Path

import pandas as pd

from analysis.commands.common import rows_of
from analysis.table import finished
from sweep.errors import InputError

REST = 5.0  # a reading is followed by a rest of so many times its duration


class Growing:
    """The rows of the table at `path`; several threads may ask.

    Raises
    ------
    InputError
        Where there is no table to read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._stamp: tuple[int, int] | None = None
        self._next: float  # when it may be read again, once it was
        self._frame = pd.DataFrame()
        self.rows()

    def rows(self) -> pd.DataFrame:
        """All rows as they are now, or were a moment ago."""
        with self._lock:
            stamp = self._stamp_now()
            if self._stamp is None or (stamp != self._stamp and time.monotonic() >= self._next):
                start = time.monotonic()
                try:
                    self._frame, self._stamp = rows_of(self.path), stamp
                except (InputError, OSError):  # somebody is writing it in this moment; at the next look it may be whole
                    if self._stamp is None:
                        raise
                self._next = time.monotonic() + REST * (time.monotonic() - start)
            return self._frame

    def _stamp_now(self) -> tuple[int, int] | None:
        try:
            found = self.path.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size


def version_of(rows: pd.DataFrame) -> str:
    """Differs where the rows do: a row that is computed stays as it is."""
    return f"{len(finished(rows))} of {len(rows)}"
