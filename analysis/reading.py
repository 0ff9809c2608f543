"""Read the rows of a table's file, and make a data frame of them."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sweep.errors import InputError
from sweep.files import HDF5, SPEC, kind_of, no_file
from sweep.schema import LAYOUTS, NO_RANK, RESULTS, ROW, TORN, inputs_of, is_sealed, today, was_checked
from sweep.store.disk import forget_what_was_read
from sweep.store.table import PROVENANCE, attributes
from sweep.store.unwritten import ROWS_WRITTEN_MAX, filled_in, grid_of

TORN_LABEL = TORN.decode()
# Columns that a table need not have: people's own tables, and those of earlier versions, lack some.
OPTIONAL = ("checked", "spread_low", "spread_high")
COLUMNS = tuple(name for name in ROW.names or () if name not in ("checksum", "condition", *OPTIONAL))  # the contract's
_TEXT_COLUMNS = tuple(name for name in COLUMNS if ROW[name].kind == "S")
_ROWS_AT_ONCE = 1 << 16  # rows checked at a time, so that the check needs little memory beside the table itself


def read_rows(path: Path) -> NDArray[np.void]:
    """All rows of `/results`; InputError where there are none to read."""
    with opened(path) as file:
        return _results(file, path)


def is_csv(path: str | Path) -> bool:
    """Whether a table is text, as `sweep export` makes it, by the ending of its name."""
    return Path(path).suffix.lower() == ".csv"


@contextmanager
def opened(path: str | Path) -> Iterator[h5py.File]:
    """The file open for reading; InputError where it cannot be read, or shows in the block that it is damaged."""
    refuse_no_file(Path(path))
    try:
        forget_what_was_read(Path(path))
        with _file(path) as file:
            yield file
    except InputError:
        raise
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"there is no table {path}") from None
    except PermissionError:
        raise InputError(f"{path} may not be read (permissions)") from None
    except (OSError, RuntimeError, ValueError, KeyError, TypeError):  # h5py raises any, depending on the damage
        raise InputError(not_a_table(Path(path))) from None


def refuse_no_file(path: Path) -> None:
    """InputError where there is a directory, a device or a pipe."""
    with suppress(OSError):  # whoever opens it says why
        if kind := no_file(path):
            raise InputError(f"{path} is a {kind}, not a table")


def _file(path: str | Path) -> h5py.File:
    try:
        return h5py.File(path, "r", locking=False)  # the sweep may have it open for writing, and we only look
    except OSError as error:
        if "flag values don't match" not in str(error):
            raise
        return h5py.File(path, "r")  # this program has it open already, with locking


def not_a_table(path: Path) -> str:
    """What a file is that cannot be read as a table, and for a spec which command makes a table of it."""
    try:
        kind = kind_of(path)
    except (OSError, ValueError) as error:  # a name that is too long, or holds a zero
        return f"{path} cannot be read: {getattr(error, 'strerror', None) or error}"
    if kind == SPEC:
        table = path.with_suffix(".h5")
        return f"{path} is {kind}, not a table; `sweep run {path} -o {table}` makes a table of it: give {table}"
    if kind == HDF5:
        return f"{path} is a damaged HDF5 file; `sweep run --repair` with its spec saves the intact rows of a table"
    return f"{path} is {kind}, not a table" if kind else f"{path} is not an HDF5 file, or a damaged one"


def _results(file: h5py.File, path: Path) -> NDArray[np.void]:
    data = file.get(RESULTS)
    if not isinstance(data, h5py.Dataset):
        raise InputError(f"{path} has no dataset /results; give the .h5 file that `sweep run` wrote, or a .csv of it")
    if data.dtype.names is None or data.ndim != 1:
        raise InputError(f"{path}: /results is not a list of rows with named columns")
    rows: NDArray[np.void] = data[:]
    grid = grid_of(attributes(file), len(rows)) if len(rows) > ROWS_WRITTEN_MAX and PROVENANCE in file else None
    return rows if grid is None else filled_in(grid, rows, 0)


def check_columns(dtype: np.dtype[np.void], path: str | Path) -> None:
    """InputError naming every column that is missing or of a wrong type."""
    names = dtype.names or ()
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise InputError(f"{path}: /results lacks the columns {', '.join(missing)}")
    wrong = [name for name in COLUMNS if dtype[name].kind not in ("SO" if name in _TEXT_COLUMNS else "biuf")]
    if wrong:
        wanted = ", ".join(f"{name} ({'text' if name in _TEXT_COLUMNS else 'a number'})" for name in wrong)
        raise InputError(f"{path}: /results has columns of a wrong type, wanted: {wanted}")


def torn_rows(rows: NDArray[np.void], claimed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which rows (n,) say that they are computed but do not match their checksum."""
    torn = np.zeros(len(rows), bool)
    if "checksum" in (rows.dtype.names or ()):
        tasks = np.flatnonzero(claimed)
        for start in range(0, len(tasks), _ROWS_AT_ONCE):
            some = tasks[start : start + _ROWS_AT_ONCE]
            torn[some] = ~is_sealed(_as_row(rows[some]))
    return torn


def _as_row(rows: NDArray[np.void]) -> NDArray[np.void]:
    """The columns that the checksum covers, without those that others have added."""
    names = rows.dtype.names or ()
    newest = today(rows.dtype)
    old = [one for one in LAYOUTS.values() if "checked" not in (one.names or ())]
    layout = newest if "checked" in names else old[0]
    packed = np.zeros(len(rows), layout)
    for name in layout.names or ():
        if name in names:
            packed[name] = rows[name]
    return packed


def frame_of(
    rows: NDArray[np.void], keep: NDArray[np.bool_], torn: NDArray[np.bool_], known: NDArray[np.bool_]
) -> pd.DataFrame:
    """A data frame of the rows to `keep`; those that are not `known`, since not computed, hold only their inputs."""
    columns: dict[str, Any] = {}
    blank, kept = np.flatnonzero(~known[keep]), today(rows.dtype).names or ()
    for name in rows.dtype.names or ():
        kind = "" if name == "checksum" else rows.dtype[name].kind  # it has served its purpose
        ours = name in kept and name not in (*inputs_of(rows.dtype), "status")
        if kind in ("S", "O"):
            column = rows[name][keep]
            column[blank if ours else []] = b""
            columns[name] = labels(column, torn[keep] if name == "status" else None)
        elif kind in ("b", "i", "u", "f"):  # what is left are nested and array columns, which a frame cannot hold
            # In the machine's byte order, the only one that pandas computes with.
            columns[name] = rows[name][keep].astype(rows.dtype[name].newbyteorder("="), copy=False)
            columns[name][blank if ours else []] = _nothing(name, kind)
    checked = columns.get("checked", was_checked(columns["error"], columns["chaotic"].astype(bool)))
    ordered = {}
    for name, column in columns.items():
        ordered[name] = column
        if name == "chaotic":
            ordered["checked"] = checked.astype(bool, copy=False)
            ordered[name] = pd.arrays.BooleanArray(column.astype(bool), ~ordered["checked"])
    # Without copy the columns stay as they are; consolidating them would double the memory for nothing.
    return pd.DataFrame(ordered, index=pd.Index(np.flatnonzero(keep), name="task"), copy=False)


def _nothing(name: str, kind: str) -> float:
    """What a column of numbers holds in a row that was not computed."""
    return np.nan if kind == "f" else NO_RANK if name == "rank" else 0


def labels(column: NDArray[Any], torn: NDArray[np.bool_] | None = None) -> pd.Categorical:
    """A column of text as a categorical; torn rows are labelled as such."""
    values = column.astype(object)
    if torn is not None:
        values[torn] = TORN_LABEL.encode()
    codes, found = pd.factorize(values, sort=True)
    # latin-1 decodes any bytes, and different ones differently: a damaged row cannot stop the reading.
    names = [value.decode("latin-1") if isinstance(value, bytes) else str(value) for value in found]
    categories: Any = pd.Index(names, dtype=str)
    return pd.Categorical.from_codes(codes, categories=categories)
