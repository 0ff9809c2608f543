"""One run per table: a lock file beside it, which the system releases when the holder dies."""

import fcntl
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sweep.errors import InputError

TRIES_MAX, TRY_EVERY = 5, 0.02  # tries, seconds: whoever asks `is_held` has the lock for a moment too


@contextmanager
def only_run(table: Path) -> Iterator[None]:
    """Hold the lock of `table`; InputError where another run holds it or the folder cannot be written."""
    path, tries = _place(table), 0
    while True:
        try:
            file = path.open("w")
        except OSError as error:
            raise InputError(f"{table}: its folder cannot be written: {error.strerror}") from None
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                tries += 1
                if tries < TRIES_MAX:
                    time.sleep(TRY_EVERY)
                    continue
                raise InputError(f"{table}: another run is writing this table; wait for it or stop it") from None
            except OSError as error:
                raise InputError(f"{table}: its file system has no locks ({error.strerror}); use another") from None
            if not _is_still(file.fileno(), path):
                continue  # its last holder removed it between our opening and our locking
            try:
                yield
            finally:
                path.unlink(missing_ok=True)
            return


def is_held(table: Path) -> bool:
    """Whether a run holds the lock of `table`. Of a run on another host only some file systems know."""
    try:
        with _place(table).open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def real(table: Path) -> Path:
    """The path behind a link, so that a new table replaces the old table and not the link."""
    return Path(os.path.realpath(table)) if table.is_symlink() else table


def _place(table: Path) -> Path:
    path = Path(os.path.realpath(table))  # two names of one table share the lock
    return path.with_name(f".{path.name}.lock")


def _is_still(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
