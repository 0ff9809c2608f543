"""The rows of the results file (contract): what the scheduler writes and the analysis reads."""

import zlib

import numpy as np
from numpy.typing import NDArray

RESULTS, RUNS = "results", "runs"  # the datasets: one row per task, one row per run that touched the table

ROW = np.dtype(
    [
        ("N", "<i4"),
        ("zeta_T", "<f8"),
        ("M_over_M0", "<f8"),
        ("V_over_V0", "<f8"),
        ("ke_bistable", "<f8"),  # over the initial total energy TE, as is ke_linear
        ("ke_linear", "<f8"),
        ("ke_ratio", "<f8"),
        ("t_peak_bistable", "<f8"),  # over N, as is t_peak_linear
        ("t_peak_linear", "<f8"),
        ("error", "<f8"),  # estimated relative error of ke_ratio, nan where not estimated
        ("chaotic", "?"),
        ("spread_low", "<f8"),  # ke_ratio over the neighbours of a chaotic task, nan of another
        ("spread_high", "<f8"),
        ("method", "S16"),
        ("steps", "<i8"),
        ("seconds", "<f8"),
        ("rank", "<i4"),
        ("status", "S16"),
        ("checksum", "<u4"),  # of the columns before it; a row whose checksum fails counts as never computed
    ]
)
RUN = np.dtype(
    [
        ("start", "<f8"),  # seconds since 1970
        ("updated", "<f8"),  # the last time the master was seen alive
        ("ended", "?"),  # it said so; a run that was killed never does
        ("left_at_start", "<i8"),
        ("left", "<i8"),
        ("work_left_at_start", "<f8"),  # predicted core seconds
        ("work_left", "<f8"),  # of what is not handed out yet
        ("work_running", "<f8"),
        ("work_finished", "<f8"),
        ("busy", "<f8"),  # real core seconds of what is finished
        ("ranks", "<i4"),
        ("computing", "<i4"),  # ranks that compute: rank 0 does not where it has many to serve
        ("requests", "<i8"),  # for work, that rank 0 has answered
        ("busy_share", "<f8"),  # of all ranks, and of the least busy one; this and what follows are known at the end
        ("least_busy_share", "<f8"),
        ("waited", "<f8"),  # seconds that all ranks waited for work
        ("waited_cpu", "<f8"),  # core seconds that this took
        ("tail", "<f8"),  # seconds between the first rank running dry and the end
        ("serving", "<f8"),  # core seconds that serving took rank 0
        ("writer", "S8"),
        ("kernel", "S16"),  # hash of the kernel that computed
        ("host", "S64"),
        ("hosts", "S192"),  # of all ranks, with how many on each
        ("job", "S64"),  # SLURM's number, array task and restart; empty outside of SLURM
    ]
)

PARAMETERS = ("N", "zeta_T", "M_over_M0", "V_over_V0")
PENDING, DONE = b"pending", b"done"
UNASKED = b"unasked"  # the status of a row that an adaptive sweep has not needed so far
LATEST = 2.5e11  # seconds since 1970 that a time may be: the year 9892
# These tell about the run, not about the task: they differ between two runs of one spec. All others never do.
RUN_COLUMNS = ("seconds", "rank", "checksum")

_COVERED = ROW.itemsize - ROW["checksum"].itemsize


def text_of(value: bytes) -> str:
    """A text column's value; what is damaged is no reason to fail."""
    return value.decode(errors="replace")


def seal(rows: NDArray[np.void]) -> None:
    """Fill in the checksum of every row, in place."""
    rows["checksum"] = _checksums(rows)


def is_sealed(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows hold exactly what was sealed."""
    return np.asarray(rows["checksum"] == _checksums(rows))


def is_ended(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows are computed, done or failed, and intact."""
    return ~np.isin(rows["status"], (PENDING, UNASKED)) & is_sealed(rows)


def _checksums(rows: NDArray[np.void]) -> NDArray[np.uint32]:
    raw = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), ROW.itemsize)[:, :_COVERED]
    return np.fromiter((zlib.crc32(row.tobytes()) for row in raw), np.uint32, len(rows))
