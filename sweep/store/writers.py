"""Who writes finished rows: every rank its own (mpio), or rank 0 for all (gather)."""

import errno
import fcntl
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError, UnwritableTableError
from sweep.log import say
from sweep.plan.tasks import Ids
from sweep.schema import RESULTS, RUNS
from sweep.store.structure import place
from sweep.store.table import reading, write_rows

NAMES = ("auto", "mpio", "gather")
CANNOT_FLUSH = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)  # what a file system says that has no flush; no row is lost


def choose(wanted: str, ranks: int) -> tuple[str, str]:
    """The writer to use and why; InputError where the wanted one cannot work here."""
    parallel = bool(h5py.get_config().mpi)
    if wanted == "mpio" and not parallel:
        raise InputError("--writer mpio: this h5py has no parallel HDF5; use --writer gather or build it (make setup)")
    if wanted == "mpio" and ranks == 1:
        raise InputError("--writer mpio: needs more than one rank; start with mpirun -n K, or use --writer gather")
    if wanted != "auto":
        return wanted, "asked for"
    if ranks == 1:
        return "gather", "one process"
    return ("mpio", "parallel HDF5") if parallel else ("gather", "this h5py has no parallel HDF5")


@contextmanager
def _reported(path: Path) -> Iterator[None]:
    """What the disk refuses becomes one message: a disk that is full or broken is the user's to mend."""
    try:
        yield
    except OSError as error:
        raise UnwritableTableError(path, error) from None


class Gather:
    """Rank 0 writes for all, past HDF5, which keeps small writes back and does not report when they fail in the end.

    The system has what is written at once, and HDF5's own lock keeps other programs from writing too.
    """

    def __init__(self, path: Path, flush_every: float) -> None:
        with reading(path) as file:
            self._first = {name: place(file[name])[0] for name in (RESULTS, RUNS)}
        self._path, self._descriptor = path, os.open(path, os.O_RDWR)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{path}: is open in another program, which must close it first") from None
        self._flusher = Flusher(path, flush_every)

    def write(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Store the rows so that killing any process afterwards does not lose them."""
        self._write(RESULTS, ids, rows)

    def log(self, slot: int, run: NDArray[np.void]) -> None:
        """Overwrite one row of the list of runs (shape (1,)); rank 0 only."""
        self._write(RUNS, np.array([slot]), run)

    def _write(self, name: str, ids: Ids, rows: NDArray[np.void]) -> None:
        size, first = rows.itemsize, self._first[name]
        with _reported(self._path):
            for part in np.split(np.arange(len(ids)), np.flatnonzero(np.diff(ids) != 1) + 1):
                _write_at(self._descriptor, rows[part].tobytes(), first + int(ids[part[0]]) * size)

    def close(self) -> None:
        """Flush and close; with Mpio all ranks together."""
        self._flusher.close()
        with _reported(self._path):
            os.close(self._descriptor)


def _write_at(descriptor: int, data: bytes, offset: int) -> None:
    while data:
        written = os.pwrite(descriptor, data, offset)
        data, offset = data[written:], offset + written


class Mpio:
    """Every rank writes its own rows independently; MPI-IO hands them to the system at once, so no flush."""

    def __init__(self, path: Path, comm: Any, flush_every: float) -> None:
        self._path, self._file = path, h5py.File(path, "r+", driver="mpio", comm=comm)
        self._flusher = Flusher(path, flush_every)

    def write(self, ids: Ids, rows: NDArray[np.void]) -> None:
        with _reported(self._path):
            write_rows(self._file[RESULTS], ids, rows)

    def log(self, slot: int, run: NDArray[np.void]) -> None:
        with _reported(self._path):
            write_rows(self._file[RUNS], np.array([slot]), run)

    def close(self) -> None:
        with _reported(self._path):
            self._file.close()
        self._flusher.close()


Writer = Gather | Mpio  # an open table that takes finished rows


class Flusher:
    """A thread that writes an open table from memory to the disk every `every` seconds and at the end.

    This bounds what a power failure can cost. On a local disk the whole file is flushed; on a network file system,
    what this machine has written.
    """

    def __init__(self, path: Path, every: float) -> None:
        self._path, self._every, self._closing = path, every, threading.Event()
        self._descriptor, self._lost = os.open(path, os.O_RDONLY), False
        self._thread = threading.Thread(target=self._run, name="flusher", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._closing.wait(self._every) and self._flush():
            pass

    def _flush(self) -> bool:
        try:
            os.fsync(self._descriptor)
        except OSError as error:
            self._lost = error.errno not in CANNOT_FLUSH
            say(f"{self._path}: cannot be flushed to the disk ({error.strerror}); a power failure may cost rows")
            return False
        return True

    def close(self) -> None:
        """Flush what the last batches wrote. InputError where the disk has not taken all that was written."""
        self._closing.set()
        self._thread.join()
        lost = self._lost or (not self._flush() and self._lost)
        os.close(self._descriptor)
        if lost:
            raise InputError(
                f"{self._path}: its disk has not taken all rows; mend that, copy the table, then run again: torn rows "
                "are found and computed again"
            )
