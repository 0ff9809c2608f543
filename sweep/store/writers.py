"""Who writes finished rows: every rank its own (mpio), or rank 0 for all (gather)."""

import fcntl
import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError, UnwritableTableError
from sweep.log import say
from sweep.plan.tasks import Ids
from sweep.schema import RESULTS, RUNS, SCREENED, sealed_values
from sweep.store import disk
from sweep.store.structure import CHANGING, place
from sweep.store.table import reading, write_rows

NAMES = ("auto", "mpio", "gather")
FOR_EVER = threading.TIMEOUT_MAX  # seconds


def choose(wanted: str, ranks: int, hosts: int = 1, place: Path = Path()) -> tuple[str, str]:
    """The writer to use for a table at `place` and why; InputError where the wanted one cannot work here."""
    parallel = bool(h5py.get_config().mpi)
    if wanted == "mpio" and not parallel:
        raise InputError("--writer mpio: this h5py has no parallel HDF5; use --writer gather or build it (make setup)")
    if wanted == "mpio" and ranks == 1:
        raise InputError("--writer mpio: needs more than one rank; start with mpirun -n K, or use --writer gather")
    if wanted != "auto":
        return wanted, "asked for"
    if ranks == 1:
        return "gather", "one process"
    if not parallel:
        return "gather", "this h5py has no parallel HDF5"
    if hosts > 1 and not disk.is_coherent(place):
        return "gather", f"{hosts} nodes on {disk.kind_of(place)}, where only one should write a file"
    return "mpio", "parallel HDF5"


class Waiting:
    """For how long a disk has kept somebody waiting."""

    def __init__(self) -> None:
        self._since: dict[int, float] = {}  # by thread

    def seconds(self) -> float:
        """Of the longest wait that is going on; 0 where there is none."""
        return max((time.monotonic() - since for since in list(self._since.values())), default=0.0)

    @contextmanager
    def counted(self) -> Iterator[None]:
        """What happens now is a wait, or part of one that has begun."""
        thread = threading.get_ident()
        begun = thread in self._since
        if not begun:
            self._since[thread] = time.monotonic()
        try:
            yield
        finally:
            if not begun:
                del self._since[thread]

    @contextmanager
    def on(self, path: Path) -> Iterator[None]:
        """What the disk refuses becomes one message: a disk that is full or broken is the user's to mend."""
        try:
            with self.counted():
                yield
        except (OSError, RuntimeError) as error:  # HDF5's, of what is no plain reading or writing
            raise UnwritableTableError(path, error) from None


class Gather:
    """Rank 0 writes for all, past HDF5, which keeps small writes back and does not report when they fail in the end.

    The system has what is written at once, and HDF5's own lock keeps other programs from writing too.
    """

    def __init__(self, path: Path, flush_every: float) -> None:
        with reading(path) as file:
            self._first = {name: place(file[name])[0] for name in CHANGING if name in file}
        self.waiting = Waiting()
        self._path, self._descriptor = path, os.open(path, os.O_RDWR)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{path}: is open in another program, which must close it first") from None
        self._flusher = Flusher(path, flush_every, self.waiting)

    def write(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Store the rows so that killing any process afterwards does not lose them."""
        self._write(RESULTS, ids, rows)

    def log(self, slot: int, run: NDArray[np.void]) -> None:
        """Overwrite one row of the list of runs (shape (1,)); rank 0 only."""
        self._write(RUNS, np.array([slot]), run)

    def seen(self, places: Ids, values: NDArray[np.float64]) -> None:
        """Keep what screening or trying gave at these places of the dataset SCREENED; rank 0 only."""
        self._write(SCREENED, places, sealed_values(values))

    def _write(self, name: str, ids: Ids, rows: NDArray[np.void]) -> None:
        self._flusher.check()
        size, first = rows.itemsize, self._first[name]
        data, numbers = rows.tobytes(), ids.tolist()
        ends = [0, *(np.flatnonzero(np.diff(ids) != 1) + 1).tolist(), len(ids)]  # of rows that follow each other
        with self.waiting.on(self._path):
            for start, end in pairwise(ends):
                _write_at(self._descriptor, data[start * size : end * size], first + numbers[start] * size)

    def close(self) -> None:
        """Flush and close; with Mpio all ranks together."""
        self._flusher.close()
        with self.waiting.on(self._path):
            os.close(self._descriptor)


def _write_at(descriptor: int, data: bytes, offset: int) -> None:
    while data:
        written = os.pwrite(descriptor, data, offset)
        data, offset = data[written:], offset + written


class Mpio:
    """Every rank writes its own rows independently; MPI-IO hands them to the system at once, so no flush."""

    def __init__(self, path: Path, comm: Any, flush_every: float) -> None:
        self.waiting = Waiting()
        self._path, self._file = path, h5py.File(path, "r+", driver="mpio", comm=comm)
        self._lists = {name: self._file[name] for name in CHANGING if name in self._file}  # later a disk may be gone
        self._flusher = Flusher(path, flush_every, self.waiting)

    def write(self, ids: Ids, rows: NDArray[np.void]) -> None:
        self._flusher.check()
        with self.waiting.on(self._path):
            write_rows(self._lists[RESULTS], ids, rows)

    def log(self, slot: int, run: NDArray[np.void]) -> None:
        with self.waiting.on(self._path):
            write_rows(self._lists[RUNS], np.array([slot]), run)

    def seen(self, places: Ids, values: NDArray[np.float64]) -> None:
        with self.waiting.on(self._path):
            write_rows(self._lists[SCREENED], places, sealed_values(values))

    def close(self) -> None:
        with self.waiting.on(self._path):
            self._file.close()
        self._flusher.close()


Writer = Gather | Mpio  # an open table that takes finished rows


class Flusher:
    """A thread that writes an open table from memory to the disk every `every` seconds and at the end.

    This bounds what a power failure can cost. On a local disk the whole file is flushed; on a network file system,
    what this machine has written.
    """

    def __init__(self, path: Path, every: float, waiting: Waiting) -> None:
        self._path, self._every, self._waiting, self._closing = path, every, waiting, threading.Event()
        self._descriptor, self._lost, self._flushed = os.open(path, os.O_RDONLY), "", time.monotonic()
        self._thread = threading.Thread(target=self._run, name="flusher", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._closing.wait(self._every) and self._flush():
            pass

    def _flush(self) -> bool:
        try:
            with self._waiting.on(self._path):
                self._sync()
        except UnwritableTableError as error:
            seconds = time.monotonic() - self._flushed
            self._lost = (
                f"{error.problems[0].partition(';')[0]}; rows that were reported in the last {seconds:.0f} s may be "
                "lost; mend the disk, then run again: lost and torn rows are found and computed again"
            )
            return False
        self._flushed = time.monotonic()
        return True

    def _sync(self) -> None:
        try:
            os.fsync(self._descriptor)
        except OSError as error:
            if error.errno not in disk.CANNOT_FLUSH:
                raise
            say(f"{self._path}: its file system cannot flush ({error.strerror}); a power failure may cost rows")
            self._every = FOR_EVER

    def check(self) -> None:
        """InputError where the disk has not taken all that was written."""
        if self._lost:
            raise InputError(self._lost)

    def close(self) -> None:
        """Flush what the last batches wrote; InputError as `check`."""
        self._closing.set()
        self._thread.join()
        if not self._lost and self._every < FOR_EVER:
            self._flush()
        os.close(self._descriptor)
        self.check()
