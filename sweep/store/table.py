"""The results file: created whole before anything is computed, then only overwritten row by row.

The datasets are contiguous and allocated at once, the file is closed once before use, in the default library version,
and no run changes its structure: all this keeps the file readable when a process is killed.
"""

import json
import os
import shutil
import stat
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.errors import DamagedTableError, InputError
from sweep.files import HDF5, kind_of
from sweep.plan.tasks import Ids, TaskList, Tasks
from sweep.schema import (
    DONE,
    FORMAT,
    RESULTS,
    REUSED,
    ROW,
    RUN,
    RUNS,
    SCREENED,
    SCREENED_PER_TASK,
    SCREENED_ROW,
    TIME_MAX,
    as_rows,
    is_ended,
    is_layout,
    seal,
    text_of,
)
from sweep.store.disk import forget_what_was_read
from sweep.store.structure import PROVENANCE as PROVENANCE
from sweep.store.structure import STRUCTURE, has_our_name, lost, seal_structure, structure_is_whole
from sweep.store.unwritten import Sparse, filled_in, grid_of, pending, probes

CHOSEN = "chosen"  # among the provenance of a merged table, where a search has chosen some of its rows
RUNS_MAX = 1000  # length of the list of runs, which cannot grow; a further run overwrites the last (`next_slot`)
ROWS_MEASURED = 1000  # of a table made to measure its size: further rows add nothing but themselves
OVERHEAD_MAX = 1 << 16  # bytes, more than HDF5 needs around the data
ROWS_AT_ONCE = 1 << 18  # 40 MB in memory


def create(
    path: Path,
    tasks: TaskList,
    attributes: Mapping[str, str],
    fill: Callable[[h5py.File], None] = lambda _: None,
    layout: np.dtype[Any] = ROW,
    screens: bool = False,
) -> None:
    """Write a table of pending rows, and what `fill` puts over them; it appears under its name only when complete.

    screens: whether the table also keeps what screening and trying give. The caller holds its lock.
    """
    texts = {name: text.encode() for name, text in attributes.items()}
    rows = len(tasks) * (layout.itemsize + screens * SCREENED_PER_TASK * SCREENED_ROW.itemsize)
    need = rows + RUNS_MAX * RUN.itemsize + sum(map(len, texts.values())) + OVERHEAD_MAX
    partial = clear(path)
    free = shutil.disk_usage(path.parent).free
    if need > free:
        raise InputError(
            f"{path}: the table needs {need / 1e9:.3g} GB, its disk has {free / 1e9:.3g} GB free; "
            "make room, or give another -o"
        )
    try:
        with partial.open("wb") as reserved:  # a quota says no here; HDF5 would crash half-way
            os.posix_fallocate(reserved.fileno(), 0, need)
        # Without locking: nobody else knows this file, and some disks let go of a lock only a while after the closing.
        with h5py.File(partial, "w", locking=False) as file:
            _fill(_lay_out(file, texts, len(tasks), layout, screens), tasks, attributes)
            fill(file)
        seal_structure(partial)
        _to_disk(partial)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def clear(path: Path) -> Path:
    """Remove what a creation that was killed has left, which takes the room of a table; its name."""
    partial = path.with_name(f".{path.name}.partial")
    partial.unlink(missing_ok=True)
    return partial


def size(rows: int, attributes: Mapping[str, str], layout: np.dtype[Any] = ROW, screens: bool = False) -> int:
    """Bytes of the file that `create` writes for so many tasks: of the same layout in memory, with few rows."""
    few = min(rows, ROWS_MEASURED)
    with h5py.File("size", "w", driver="core", backing_store=False, block_size=512) as file:
        _lay_out(file, {name: text.encode() for name, text in attributes.items()}, few, layout, screens)
        file.flush()
        each = layout.itemsize + screens * SCREENED_PER_TASK * SCREENED_ROW.itemsize
        return int(file.id.get_filesize()) + (rows - few) * each


def _lay_out(
    file: h5py.File, texts: Mapping[str, bytes], rows: int, layout: np.dtype[Any], screens: bool
) -> h5py.Dataset:
    """Make everything but the content of the rows; the dataset of the rows."""
    file.attrs["format"] = np.bytes_(FORMAT)  # a string of variable length can crash HDF5 where it is damaged
    file.create_group(PROVENANCE)
    for name, text in texts.items():
        # A dataset, because an attribute may not exceed 64 KB.
        file.create_dataset(f"{PROVENANCE}/{name}", data=np.bytes_(text))
    _preallocate(file, STRUCTURE, 1, np.dtype("<u4"))
    _preallocate(file, RUNS, RUNS_MAX, RUN)
    if screens:
        _preallocate(file, SCREENED, rows * SCREENED_PER_TASK, SCREENED_ROW)
    return _preallocate(file, RESULTS, rows, layout)


def _preallocate(file: h5py.File, name: str, rows: int, dtype: np.dtype[Any]) -> h5py.Dataset:
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    space, kind = h5py.h5s.create_simple((rows,)), h5py.h5t.py_create(dtype, logical=True)
    return h5py.Dataset(h5py.h5d.create(file.id, name.encode(), kind, space, dcpl=properties))


def _fill(results: h5py.Dataset, tasks: TaskList, known: Mapping[str, str]) -> None:
    """Write every row; of a large grid a few, as the others are known without.

    Rows that alone tell which tasks there are, those of a list or a shard, are sealed: no damage makes them others.
    """
    if grid_of(known, len(tasks)) is not None:
        ids = probes(len(tasks))
        write_rows(results, ids, pending(tasks.columns(ids), results.dtype))
        return
    for part in parts(0, len(tasks)):
        rows = pending(tasks.columns(np.arange(part.start, part.stop)), results.dtype)
        if not isinstance(tasks, Tasks):
            seal(rows)
        results[part] = rows


def _to_disk(path: Path) -> None:
    """Write the file to the disk, with room for what HDF5 left out: a disk that fills up later costs no row."""
    with path.open("r+b") as file:
        os.posix_fallocate(file.fileno(), 0, path.stat().st_size)
        os.fsync(file.fileno())


@contextmanager
def reading(path: Path) -> Iterator[h5py.File]:
    """The table open for reading, also while it is being written; InputError where it is not one of ours."""
    try:
        kind = path.stat().st_mode
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if not stat.S_ISREG(kind):  # opening a pipe would wait for ever
        raise InputError(f"{path}: is a {'directory' if stat.S_ISDIR(kind) else 'device or pipe'}, not a table")
    try:
        forget_what_was_read(path)
        file = h5py.File(path, "r", locking=False)
    except OSError as error:
        _refuse_another_kind(path)
        if _is_open_here(path):
            raise InputError(f"{path}: is open elsewhere in this process, which must close it first") from None
        raise DamagedTableError(path, f"is not a readable HDF5 file ({error})") from None
    with file:
        try:
            lacks = lost(file)
            ours = not lacks and _is_ours(file)
            whole = ours and structure_is_whole(file)
        except Exception as error:  # whatever h5py raises where the file's structure is damaged
            raise DamagedTableError(path, f"is damaged ({error})") from None
        if lacks:
            raise DamagedTableError(path, f"is damaged (its {lacks} cannot be found)")
        if not ours:
            raise InputError(f"{path}: is HDF5, but not a table that this version of bistable-sweep can read")
        if not whole:
            raise DamagedTableError(path, "is damaged (the checksum of its structure does not hold)")
        yield file


def _refuse_another_kind(path: Path) -> None:
    """InputError where the file never was a table, so that there is nothing to repair."""
    try:
        kind = kind_of(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if kind not in (None, HDF5):
        raise InputError(f"{path}: is {kind}, not a table; give the .h5 file that `sweep run` or `sweep merge` wrote")


def _is_open_here(path: Path) -> bool:
    """Whether this process has the file open: HDF5 opens none twice in different ways."""
    names = (h5py.h5f.get_name(one) for one in h5py.h5f.get_obj_ids(h5py.h5f.OBJ_ALL, h5py.h5f.OBJ_FILE))
    return any(os.path.realpath(os.fsdecode(name)) == os.path.realpath(path) for name in names)


def _is_ours(file: h5py.File) -> bool:
    wanted = {RUNS: RUN, STRUCTURE: np.dtype("<u4")}
    wanted |= {SCREENED: SCREENED_ROW} if SCREENED in file else {}
    return (
        has_our_name(file)
        and is_layout(file[RESULTS].dtype)
        and all(file[name].dtype == layout for name, layout in wanted.items())
    )


def attributes(file: h5py.File) -> dict[str, str]:
    """The provenance written at creation."""
    try:
        return {name: bytes(item[()]).decode() for name, item in file[PROVENANCE].items()}
    except Exception as error:  # as in `reading`
        raise DamagedTableError(file.filename, f"is damaged (its provenance: {error})") from None


def resolved(file: h5py.File) -> dict[str, Any]:
    """The spec with all its defaults, section by section; InputError where the provenance lacks it."""
    known = attributes(file)
    try:
        spec = json.loads(known["resolved"])
    except (KeyError, ValueError, RecursionError):
        spec = None
    if not isinstance(spec, dict) or not all(isinstance(spec[name], dict) for name in spec.keys() - {"name"}):
        raise InputError(f"{file.filename}: its provenance does not tell its spec")
    return spec


def finished(file: h5py.File, retry_failed: bool = False) -> NDArray[np.bool_]:
    """Which rows need no more work: computed (done or failed, unless those are to be retried) and intact."""
    mask = np.zeros(len(file[RESULTS]), np.bool_)
    for part, rows in written(file):
        mask[part] = is_ended(rows) & ((rows["status"] == DONE) | (not retry_failed))
    return mask


def counts(file: h5py.File) -> tuple[int, int, int]:
    """How many rows are done, failed, left."""
    ended = kinds(file)
    done = ended[text_of(DONE)]
    return done, ended.total() - done, len(file[RESULTS]) - ended.total()


def kinds(file: h5py.File) -> Counter[str]:
    """How many rows ended with which status."""
    ended: Counter[str] = Counter()
    for rows in finished_rows(file):
        ended.update(statuses(rows))
    return ended


def statuses(rows: NDArray[np.void]) -> dict[str, int]:
    """How many of the rows have which status."""
    words, counted = np.unique(rows["status"], return_counts=True)
    return {text_of(word): int(count) for word, count in zip(words, counted, strict=True)}


def chunks(file: h5py.File) -> Iterator[tuple[slice, NDArray[np.void]]]:
    """All rows, part by part, in today's layout."""
    grid = grid_of(attributes(file), len(file[RESULTS]))
    for part in parts(0, len(file[RESULTS])):
        rows = as_rows(_read(file[RESULTS], part))
        yield part, rows if grid is None else filled_in(grid, rows, part.start)


def written(file: h5py.File) -> Iterator[tuple[slice, NDArray[np.void]]]:
    """The same without parts that nobody has written; what is unwritten in the others is all zero."""
    with Sparse(file) as sparse:
        for part in parts(0, len(file[RESULTS])):
            if (rows := _read(file[RESULTS], part, sparse)) is not None:
                yield part, as_rows(rows)


def parts(begin: int, end: int) -> Iterator[slice]:
    """Of the rows from one number up to another, ROWS_AT_ONCE each: a large table does not fit the memory."""
    return (slice(first, min(first + ROWS_AT_ONCE, end)) for first in range(begin, end, ROWS_AT_ONCE))


def _read(dataset: h5py.Dataset, part: slice, sparse: Sparse | None = None) -> Any:
    try:
        return sparse.read(part) if sparse is not None and sparse.serves else dataset[part]
    except OSError as error:  # a bad disk, or the file was cut off since it was opened
        raise DamagedTableError(dataset.file.filename, f"is damaged ({error})") from None


def finished_rows(file: h5py.File) -> Iterator[NDArray[np.void]]:
    """The rows that are computed (done or failed) and intact, part by part."""
    for _, rows in written(file):
        yield rows[is_ended(rows)]


def done_rows(file: h5py.File) -> Iterator[NDArray[np.void]]:
    """Those of them that have their numbers."""
    return (rows[rows["status"] == DONE] for rows in finished_rows(file))


def kernels(file: h5py.File) -> set[str]:
    """The hashes of the kernels that have computed rows of this table, or were to."""
    return {attributes(file).get("kernel", "unknown"), *(text_of(kernel) for kernel in runs(file)["kernel"] if kernel)}


def runs(file: h5py.File) -> NDArray[np.void]:
    """The list of runs in order; a damaged row, whose times are impossible, is left out."""
    return possible(_read(file[RUNS], slice(None)))


def possible(log: NDArray[np.void]) -> NDArray[np.void]:
    """The rows of a list of runs whose times can be."""
    return log[np.all([(log[name] > 0) & (log[name] < TIME_MAX) for name in ("start", "updated")], axis=0)]


def free_slot(file: h5py.File) -> int | None:
    """The first row of the list of runs behind all that are used; None where it is full."""
    used = np.flatnonzero(_read(file[RUNS], slice(None))["start"] != 0)
    free = int(used[-1]) + 1 if len(used) else 0
    return free if free < RUNS_MAX else None


def next_slot(file: h5py.File) -> int:
    """The row of the list of runs for the next run: a free one, or the last that does not stand for reused rows."""
    if (free := free_slot(file)) is not None:
        return free
    runs = np.flatnonzero(_read(file[RUNS], slice(None))["writer"] != REUSED)
    return int(runs[-1]) if len(runs) else RUNS_MAX - 1


def read_rows(dataset: h5py.Dataset, ids: Ids) -> NDArray[np.void]:
    """Rows `ids`, in that order, of a table of today's layout."""
    rows = np.empty(len(ids), dataset.dtype)
    where = dataset.id.get_space()
    where.select_elements(ids.reshape(-1, 1).astype(np.uint64))
    dataset.id.read(h5py.h5s.create_simple((len(ids),)), where, rows)
    return rows


def write_rows(dataset: h5py.Dataset, ids: Ids, rows: NDArray[np.void]) -> None:
    """Overwrite rows `ids`; one independent write, whatever their order."""
    where = dataset.id.get_space()
    where.select_elements(ids.reshape(-1, 1).astype(np.uint64))
    dataset.id.write(h5py.h5s.create_simple((len(ids),)), where, rows)
