"""Who writes finished rows: every rank its own (mpio), or rank 0 for all (gather)."""

from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError
from sweep.flusher import Flusher
from sweep.schema import RESULTS, RUNS
from sweep.table import write_rows
from sweep.tasks import Ids

NAMES = ("auto", "mpio", "gather")


class Writer(Protocol):
    """An open table that takes finished rows."""

    def write(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Store the rows so that killing any process afterwards does not lose them."""

    def log(self, slot: int, run: NDArray[np.void]) -> None:
        """Overwrite one row of the list of runs (shape (1,)); rank 0 only."""

    def close(self) -> None:
        """Flush and close; with mpio all ranks together."""


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


class Gather:
    """Rank 0 writes through the serial driver and flushes after every batch."""

    def __init__(self, path: Path, flush_every: float) -> None:
        self._file, self._flusher = h5py.File(path, "r+"), Flusher(path, flush_every)

    def write(self, ids: Ids, rows: NDArray[np.void]) -> None:
        write_rows(self._file[RESULTS], ids, rows)
        self._file.flush()

    def log(self, slot: int, run: NDArray[np.void]) -> None:
        write_rows(self._file[RUNS], np.array([slot]), run)
        self._file.flush()

    def close(self) -> None:
        self._file.close()
        self._flusher.close()


class Mpio:
    """Every rank writes its own rows independently; MPI-IO hands them to the system at once, so no flush."""

    def __init__(self, path: Path, comm: Any, flush_every: float) -> None:
        self._file, self._flusher = h5py.File(path, "r+", driver="mpio", comm=comm), Flusher(path, flush_every)

    def write(self, ids: Ids, rows: NDArray[np.void]) -> None:
        write_rows(self._file[RESULTS], ids, rows)

    def log(self, slot: int, run: NDArray[np.void]) -> None:
        write_rows(self._file[RUNS], np.array([slot]), run)

    def close(self) -> None:
        self._file.close()
        self._flusher.close()
