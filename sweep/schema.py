"""The rows of a table (contract): what a run writes and the analysis reads."""

import zlib
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel import status
from kernel.columns import RESULT, columns_of_quantity
from kernel.task import PARAMETERS as PARAMETERS
from kernel.task import is_number_of_model

RESULTS, RUNS = "results", "runs"  # the datasets: one row per task, one row per run that touched the table
# Of a search that screens its tasks: what screening gave for each, then what trying gave, which are no results.
SCREENED, SCREENED_PER_TASK = "screened", 2

# Columns of the kernel that a table does not keep.
_NOT_KEPT = ("evaluations", "site_evaluations")


def _kept(name: str) -> tuple[str, str]:
    """A column of the kernel, with how a table stores it: a shorter N, text as bytes."""
    return name, "<i4" if name == "N" else RESULT[name].str.replace("<U", "S").replace("U", "S")


@cache
def layout_of(quantities: tuple[str, ...] = (), axes: tuple[str, ...] = ()) -> np.dtype[Any]:
    """The rows of a table that holds these quantities (kernel.quantities) beside the kinetic energy.

    axes: the numbers of the model that differ from task to task; each is a column of its name.
    """
    columns = [_kept(name) for name in RESULT.names or () if name not in _NOT_KEPT]
    columns[-1:-1] = [
        ("seconds", "<f8"),  # that the task took
        ("rank", "<i4"),  # that computed it
    ]
    columns += [(name, "<f8") for name in axes]
    columns += [(column, "<f8") for name in quantities for column in columns_of_quantity(name)]
    # Of the columns before it; a row whose checksum fails counts as never computed.
    return np.dtype([*columns, ("checksum", "<u4")])


ROW = layout_of()
COLUMNS = ROW.names or ()
# These differ between two runs of one spec; all other columns never do.
RUN_COLUMNS = ("seconds", "rank", "checksum")
FORMAT = "bistable-sweep table 3"  # what a table is called in its file; those of 0.1.0 do not say what was checked
_OLD = [name for name in COLUMNS if name not in ("condition", "checked")]
LAYOUTS = {"bistable-sweep table 2": np.dtype([(name, ROW[name]) for name in _OLD]), FORMAT: ROW}
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
        ("hosts", "S192"),  # of all ranks, with how many on each, and the kinds of processors (sweep.store.runs)
        ("job", "S64"),  # as the scheduler's users name it, with its restart; empty outside of any
    ]
)

# What screening or trying gave for a task, and the checksum of it, 0 where it was not.
SCREENED_ROW = np.dtype([("value", "<f8"), ("checksum", "<u4")])
REUSED = b"reuse"  # the `writer` of rows taken from another table: `left_at_start` of them, from the table `hosts`
PENDING = b"pending"  # the status of a row that is to be computed
DONE = status.WORDS[status.DONE].encode()
RAISED = status.WORDS[status.ERROR].encode()  # of a task that raised an exception, which can be the machine's fault
TORN = b"torn"  # never in a table: what readers call a row whose checksum fails
UNASKED = b"unasked"  # the status of a row that an adaptive sweep has not needed so far
TIME_MAX = 2.5e11  # seconds since 1970, in the year 9892: Python's dates end in 9999
NO_RANK = -1  # of a row that nobody has computed
TOGETHER = 256  # rows whose checksums are looked at in one: where one is damaged, each is looked at


def quantities_of(layout: np.dtype[Any]) -> tuple[str, ...]:
    """The quantities whose four columns rows of this layout have."""
    names = layout.names or ()
    new = [name for name in names if name not in COLUMNS]
    return tuple(name for name in new if all(column in names for column in columns_of_quantity(name)))


def axes_of(layout: np.dtype[Any]) -> tuple[str, ...]:
    """The columns of rows of this layout that are numbers of the model."""
    return tuple(name for name in layout.names or () if is_number_of_model(name))


def inputs_of(layout: np.dtype[Any]) -> tuple[str, ...]:
    """The columns that say which task a row of this layout is."""
    return (*PARAMETERS, *axes_of(layout))


def today(layout: np.dtype[Any]) -> np.dtype[Any]:
    """What rows of any layout (`is_layout`) are as rows of this version."""
    return layout_of(quantities_of(layout), axes_of(layout))


def content_columns(layout: np.dtype[Any]) -> tuple[str, ...]:
    """The columns that never differ between two runs of one spec."""
    return tuple(name for name in layout.names or () if name not in RUN_COLUMNS)


def content_of(rows: NDArray[np.void]) -> NDArray[np.void]:
    """These columns as one value per row, without gaps: a view of some columns keeps the others' bytes in between."""
    names = list(content_columns(rows.dtype))
    return whole(rows[names].astype([(name, rows.dtype[name]) for name in names]))


def whole(rows: NDArray[np.void]) -> NDArray[np.void]:
    """The rows without their columns: numpy copies and compares them at once, and not column by column."""
    return rows.view(f"V{rows.itemsize}")


def blank(count: int, layout: np.dtype[Any] = ROW) -> NDArray[np.void]:
    """Rows (count,) of which nothing is known: numbers nan, text empty, flags false, no steps, no rank."""
    row = np.zeros(1, layout)
    for name in layout.names or ():
        if layout[name].kind == "f":
            row[name] = np.nan
    row["rank"] = NO_RANK
    return np.repeat(row, count)


def blank_of(parameters: Mapping[str, NDArray[Any]], layout: np.dtype[Any] = ROW) -> NDArray[np.void]:
    """Rows of which nothing is known but these parameters, each (n,)."""
    rows = blank(len(parameters[PARAMETERS[0]]), layout)
    for name, values in parameters.items():
        rows[name] = values
    return rows


def without_numbers(rows: NDArray[np.void], where: NDArray[np.bool_]) -> NDArray[np.void]:
    """The rows, of which those at `where` keep nothing but their parameters and their status."""
    if not where.any():
        return rows
    empty = blank_of({name: rows[name] for name in inputs_of(rows.dtype)}, rows.dtype)
    empty["status"] = rows["status"]
    return np.where(where, empty, rows)


def text_of(value: bytes) -> str:
    """The text of a value of a text column; damaged bytes are replaced, not refused."""
    return value.decode(errors="replace")


def seal(rows: NDArray[np.void]) -> None:
    """Fill in the checksum of every row, in place."""
    rows["checksum"] = _checksums(rows)


def is_sealed(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows, of any layout, hold exactly what was sealed."""
    size, raw, sealed = rows.dtype.itemsize, memoryview(rows.tobytes()), np.ones(len(rows), np.bool_)
    for first in range(0, len(rows), TOGETHER):
        some = slice(first, min(first + TOGETHER, len(rows)))
        if zlib.crc32(raw[some.start * size : some.stop * size]) != _of_sealed(some.stop - first, size):
            sealed[some] = rows["checksum"][some] == _checksums(rows[some])
    return sealed


@cache
def _of_sealed(count: int, size: int) -> int:
    """The CRC of so many sealed rows, each with its checksum, whatever they hold.

    A CRC is linear, and a row that is followed by its own is a multiple of the polynomial: what it holds leaves no
    trace. Damage of one row is found exactly as by that row's own checksum.
    """
    content = bytes(size - ROW["checksum"].itemsize)
    return zlib.crc32((content + zlib.crc32(content).to_bytes(ROW["checksum"].itemsize, "little")) * count)


def sealed_values(values: NDArray[np.float64]) -> NDArray[np.void]:
    """Rows of SCREENED_ROW that hold these values."""
    rows = np.zeros(len(values), SCREENED_ROW)
    rows["value"] = np.where(np.isnan(values), np.nan, values)  # one nan for all
    rows["checksum"] = _of_values(rows["value"])
    return rows


def is_screened(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows of SCREENED_ROW hold exactly what was sealed."""
    return np.asarray(rows["checksum"] == _of_values(rows["value"]))


def _of_values(values: NDArray[np.float64]) -> NDArray[np.uint32]:
    raw = np.ascontiguousarray(values, "<f8").tobytes()
    return np.fromiter((zlib.crc32(raw[k : k + 8]) for k in range(0, len(raw), 8)), np.uint32, len(values))


def is_ended(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows are computed, done or failed, and intact."""
    ended: NDArray[np.bool_] = is_claimed(rows) & (rows["N"] != 0)  # which rows never written have
    ended[ended] = is_sealed(rows[ended])
    return ended


def is_claimed(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows say that they are computed, intact or not."""
    return ~np.isin(rows["status"], (PENDING, UNASKED))


def is_asked(rows: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows are to be computed, and hold the inputs of their task as they were written.

    Pending rows are sealed where they alone tell the tasks of a table; elsewhere, and in tables of earlier versions,
    their checksum is 0, and they are taken at their word.
    """
    asked: NDArray[np.bool_] = rows["status"] == PENDING
    sealed = asked & (rows["checksum"] != 0)
    asked[sealed] = is_sealed(rows[sealed])
    return asked


def was_checked(error: NDArray[np.float64], chaotic: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which rows were looked at for chaos, where no column says it: those with an error estimate or flagged chaotic."""
    return np.isfinite(error) | chaotic


def is_layout(layout: np.dtype[Any] | None) -> bool:
    """Whether rows of this layout can be read, as those of tables from before a column was added.

    The layout has columns of ROW only, in that order, among them all that say which task a row is and how it ended,
    and whole quantities before the checksum.
    """
    names = (layout.names or ()) if layout is not None else ()
    needed = (*PARAMETERS, "error", "chaotic", "status", "checksum")
    if layout is None or not set(needed) <= set(names):
        return False
    full = today(layout)
    return bool(layout == np.dtype([(name, full[name]) for name in full.names or () if name in names]))


def as_rows(rows: NDArray[np.void]) -> NDArray[np.void]:
    """Rows of any layout (`is_layout`) as rows of today's, with the same quantities.

    Intact rows are sealed again; the others stay recognisable as what they were.
    """
    layout = today(rows.dtype)
    if rows.dtype == layout:
        return rows
    new, ended, claimed = blank(len(rows), layout), is_ended(rows), is_claimed(rows)
    for name in rows.dtype.names or ():
        new[name] = rows[name]
    if "checked" not in (rows.dtype.names or ()):
        new["checked"] = was_checked(rows["error"], rows["chaotic"])
    new = without_numbers(new, ~ended)
    seal(new)
    new["checksum"][claimed & ~ended] ^= 1
    new["checksum"][~claimed] = 0  # as a new table has them
    return new


def _checksums(rows: NDArray[np.void]) -> NDArray[np.uint32]:
    size, covered = rows.dtype.itemsize, rows.dtype.itemsize - ROW["checksum"].itemsize
    raw = memoryview(rows.tobytes())
    return np.fromiter((zlib.crc32(raw[k : k + covered]) for k in range(0, len(raw), size)), np.uint32, len(rows))
