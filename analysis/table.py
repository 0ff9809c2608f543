"""From the results table (HDF5) to a data frame."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.errors import InputError
from sweep.schema import DONE, RESULTS, ROW, RUNS, is_sealed

DONE_LABEL = DONE.decode()
TORN_LABEL = "torn"  # the row says done, its checksum says otherwise: it was cut short while being written
SPREAD = ("spread_low", "spread_high")  # of a chaotic row
# The contract's; the others are ours, and people's own tables may do without.
COLUMNS = tuple(name for name in ROW.names or () if name not in ("checksum", *SPREAD))
_TEXT = tuple(name for name in COLUMNS if ROW[name].kind == "S")
_CHUNK = 1 << 16  # rows checked at a time, so that the check needs little memory beside the table itself


def load(path: str | Path, done_only: bool = True) -> pd.DataFrame:
    """The rows of `/results`, one per task, indexed by task id (index name "task").

    All columns of the contract and any other scalar column of the table, with the table's units (energies
    over the initial total energy, times over N, `error` relative). `method` and `status` are categoricals
    of str. A row counts as done if its status says so and its checksum holds; a table without a checksum
    column is taken at its word. With `done_only=False` all rows come, and a row whose checksum fails has
    the status "torn". A table that is being written can be read: its unfinished rows are simply not done.

    Raises InputError for a path that is missing, a directory, not HDF5 or without `/results`, for missing
    or unusable columns (all named) and, with `done_only`, for a table without any finished row.
    """
    rows = _read(Path(path))
    _check_columns(rows.dtype, path)
    status = np.asarray(rows["status"])
    done = status == DONE
    torn = _torn(rows, done)
    if not done_only:
        return _frame(rows, np.ones(len(rows), bool), torn)
    keep = done & ~torn
    if not keep.any():
        raise no_finished_row(path, _labels(status, torn))
    return _frame(rows, keep, torn)


def wall_seconds(path: str | Path) -> float | None:
    """Wall time of all runs that touched the table, in seconds; None where the table does not say."""
    with h5py.File(path, "r", locking=False) as file:
        runs = file.get(RUNS)
        if not isinstance(runs, h5py.Dataset) or not {"start", "updated"} <= set(runs.dtype.names or ()):
            return None
        return float(np.sum(runs["updated"] - runs["start"]))


def with_spread(df: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """The names, and those of SPREAD that the frame has."""
    return [*names, *(name for name in SPREAD if name in df)]


def finished(df: pd.DataFrame) -> pd.DataFrame:
    """The done rows of a frame; all of them where the frame has no `status`."""
    if "status" not in df:
        return df
    done = df["status"] == DONE_LABEL
    return df if done.all() else df[done]


def flagged(df: pd.DataFrame) -> NDArray[np.bool_]:
    """Which rows are known to be chaotic, (n,); a row that was not checked is not among them."""
    return df["chaotic"].eq(True).fillna(False).to_numpy(dtype=bool)


def checked(df: pd.DataFrame) -> NDArray[np.bool_]:
    """Which rows were checked for chaos, (n,); without a column `checked` those with an estimated error."""
    known = df["checked"] if "checked" in df else df["error"].notna()
    return known.fillna(False).to_numpy(dtype=bool)


def require(df: pd.DataFrame, columns: tuple[str, ...]) -> None:
    """Raise InputError, naming every missing column, unless the frame has them all."""
    missing = [name for name in columns if name not in df]
    if missing:
        raise InputError(f"the data frame lacks the columns {', '.join(missing)}")


def status_counts(status: "pd.Series[Any] | pd.Categorical") -> str:
    """For example "120 done, 3 failed, 77 pending": the done rows first."""
    counts = pd.Series(status).astype(str).value_counts()
    order = sorted(counts.index, key=lambda label: (label != DONE_LABEL, label))
    return ", ".join(f"{counts[label]} {label or 'without status'}" for label in order)


def no_finished_row(path: str | Path, status: "pd.Series[Any] | pd.Categorical") -> InputError:
    """The error for a table from which nothing can be drawn; it says what the rows are instead."""
    return InputError(f"{path} has no finished row ({status_counts(status) or 'no rows at all'})")


def _read(path: Path) -> NDArray[np.void]:
    try:
        if path.is_dir():
            raise InputError(f"{path} is a directory, not a table")
        # Without locking: the sweep may have the table open for writing, and we only look.
        with h5py.File(path, "r", locking=False) as file:
            return _results(file, path)
    except FileNotFoundError:
        raise InputError(f"there is no table {path}") from None
    except PermissionError:
        raise InputError(f"{path} may not be read (permissions)") from None
    except (OSError, RuntimeError):  # h5py has both, by how deep the damage is
        raise InputError(f"{path} is not an HDF5 file, or a damaged one") from None


def _results(file: h5py.File, path: Path) -> NDArray[np.void]:
    data = file.get(RESULTS)
    if not isinstance(data, h5py.Dataset):
        raise InputError(f"{path} has no dataset /results")
    if data.dtype.names is None or data.ndim != 1:
        raise InputError(f"{path}: /results is not a list of rows with named columns")
    rows: NDArray[np.void] = data[:]
    return rows


def _check_columns(dtype: np.dtype[np.void], path: str | Path) -> None:
    names = dtype.names or ()
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise InputError(f"{path}: /results lacks the columns {', '.join(missing)}")
    wrong = [name for name in COLUMNS if dtype[name].kind not in ("SO" if name in _TEXT else "biuf")]
    if wrong:
        told = ", ".join(f"{name} ({'text' if name in _TEXT else 'a number'})" for name in wrong)
        raise InputError(f"{path}: /results has columns of a wrong type, wanted: {told}")


def _torn(rows: NDArray[np.void], done: NDArray[np.bool_]) -> NDArray[np.bool_]:
    torn = np.zeros(len(rows), bool)
    if "checksum" in (rows.dtype.names or ()):
        tasks = np.flatnonzero(done)
        for start in range(0, len(tasks), _CHUNK):
            some = tasks[start : start + _CHUNK]
            torn[some] = ~is_sealed(_as_row(rows[some]))
    return torn


def _as_row(rows: NDArray[np.void]) -> NDArray[np.void]:
    """The contract's columns as they were sealed, whatever other columns stand between them."""
    packed = np.zeros(len(rows), ROW)
    for name in ROW.names or ():
        if name in (rows.dtype.names or ()):
            packed[name] = rows[name]
    return packed


def _frame(rows: NDArray[np.void], keep: NDArray[np.bool_], torn: NDArray[np.bool_]) -> pd.DataFrame:
    columns: dict[str, Any] = {}
    for name in rows.dtype.names or ():
        kind = "" if name == "checksum" else rows.dtype[name].kind  # it has told what it has to tell
        if kind in ("S", "O"):
            columns[name] = _labels(rows[name][keep], torn[keep] if name == "status" else None)
        elif kind in ("b", "i", "u", "f"):  # what is left are nested and array columns, which a frame cannot hold
            # In the machine's byte order, the only one that pandas computes with.
            columns[name] = rows[name][keep].astype(rows.dtype[name].newbyteorder("="), copy=False)
    columns["chaotic"] = columns["chaotic"].astype(bool, copy=False)
    # Without copy the columns stay as they are; consolidating them would double the memory for nothing.
    return pd.DataFrame(columns, index=pd.Index(np.flatnonzero(keep), name="task"), copy=False)


def _labels(column: NDArray[Any], torn: NDArray[np.bool_] | None = None) -> pd.Categorical:
    values = column.astype(object)
    if torn is not None:
        values[torn] = TORN_LABEL.encode()
    codes, found = pd.factorize(values, sort=True)
    # latin-1 decodes any bytes, and different ones differently: a damaged row cannot stop the reading.
    names = [value.decode("latin-1") if isinstance(value, bytes) else str(value) for value in found]
    categories: Any = pd.Index(names, dtype=str)
    return pd.Categorical.from_codes(codes, categories=categories)
