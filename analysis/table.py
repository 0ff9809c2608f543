"""From the results table (HDF5) to a data frame."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import truth
from analysis.errors import InputError
from kernel.hints import shown
from sweep.schema import (
    DONE,
    LAYOUTS,
    NO_RANK,
    PARAMETERS,
    PENDING,
    RESULTS,
    REUSED,
    ROW,
    RUNS,
    TORN,
    UNASKED,
    is_sealed,
    text_of,
    was_checked,
)

DONE_LABEL, PENDING_LABEL, UNASKED_LABEL, TORN_LABEL = (word.decode() for word in (DONE, PENDING, UNASKED, TORN))
# Ours; people's own tables, and those of earlier versions, may do without.
OPTIONAL = ("checked", "spread_low", "spread_high")
COLUMNS = tuple(name for name in ROW.names or () if name not in ("checksum", *OPTIONAL))  # the contract's
_TEXT = tuple(name for name in COLUMNS if ROW[name].kind == "S")
_CHUNK = 1 << 16  # rows checked at a time, so that the check needs little memory beside the table itself


def load(path: str | Path, done_only: bool = True) -> pd.DataFrame:
    """The rows of a table, one per task.

    Parameters
    ----------
    path : str or Path
        A table that `sweep run` or `sweep merge` has written, or is writing: its unfinished rows are not done.
    done_only : bool
        False gives all rows.

    Returns
    -------
    pandas.DataFrame
        Indexed by task id (index name "task"). All columns of the contract and any other scalar column of the table,
        with the table's units (energies over the initial total energy, times over N, `error` relative). `method` and
        `status` are categoricals of str. `checked` says whether a row was looked at for chaos, `chaotic` is of dtype
        "boolean" and missing where it was not; in a table of an earlier version a row counts as checked that has an
        error. A row counts as computed if its status says so and its checksum holds; a table without a checksum
        column is taken at its word. With `done_only=False` a row whose checksum fails has the status "torn". Of a row
        that is not computed the numbers are nan, `method` is empty, `steps` 0 and `rank` -1.

    Raises
    ------
    InputError
        For a path that is missing, a directory, not HDF5 or without `/results`, for missing or unusable columns (all
        named) and, with `done_only`, for a table without any finished row.

    Examples
    --------
    df = analysis.load("quick.h5")
    df[df["checked"] & ~df["chaotic"].fillna(True)]    # what is known not to be chaotic
    """
    truth("done_only", done_only)
    if not isinstance(path, str | Path):
        raise InputError(f"path: must be the path of a table, got {shown(path)}")
    rows = _read(Path(path))
    _check_columns(rows.dtype, path)
    status = np.asarray(rows["status"])
    claimed = (status != PENDING) & (status != UNASKED)
    torn = _torn(rows, claimed)
    if not done_only:
        return _frame(rows, np.ones(len(rows), bool), torn, claimed & ~torn)
    keep = (status == DONE) & ~torn
    if not keep.any():
        raise no_finished_row(path, _labels(status, torn))
    return _frame(rows, keep, torn, keep)


def wall_seconds(path: str | Path) -> float | None:
    """Wall time of all runs that touched the table, in seconds; None where the table does not say."""
    with h5py.File(path, "r", locking=False) as file:
        runs = file.get(RUNS)
        if not isinstance(runs, h5py.Dataset) or not {"start", "updated"} <= set(runs.dtype.names or ()):
            return None
        return float(np.sum(runs["updated"] - runs["start"]))


def reused(path: str | Path) -> dict[str, int]:
    """From which tables (`sweep run --reuse`) how many rows were taken over; empty where the table does not say."""
    taken: dict[str, int] = {}
    with h5py.File(path, "r", locking=False) as file:
        runs = file.get(RUNS)
        if isinstance(runs, h5py.Dataset) and {"writer", "hosts", "left_at_start"} <= set(runs.dtype.names or ()):
            log = runs[()]
            for run in log[log["writer"] == REUSED]:
                source = text_of(run["hosts"])
                taken[source] = taken.get(source, 0) + int(run["left_at_start"])
    return taken


def reused_rows(path: str | Path) -> int:
    """How many rows were taken over from other tables, and cost this one no time; 0 where the table does not say."""
    return sum(reused(path).values())


def done_rows(path: str | Path) -> int:
    """How many rows say that they are done."""
    with h5py.File(path, "r", locking=False) as file:
        return int(np.count_nonzero(file[RESULTS]["status"] == DONE))


def with_optional(df: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """The names, and those of OPTIONAL that the frame has."""
    return [*names, *(name for name in OPTIONAL if name in df)]


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
    """Which rows were looked at for chaos, (n,); without a column `checked` those with an estimated error or a flag."""
    if "checked" in df:
        return df["checked"].eq(True).fillna(False).to_numpy(dtype=bool)
    error = df["error"].to_numpy(float, na_value=np.nan) if "error" in df else np.full(len(df), np.nan)
    return was_checked(error, flagged(df))


def unchecked_told(df: pd.DataFrame) -> str:
    """How many of the rows nobody looked at for chaos, in words; empty where all were."""
    count = int(np.count_nonzero(~checked(df)))
    return "" if not count else "not checked for chaos" if count == len(df) else f"{count} not checked for chaos"


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


def _torn(rows: NDArray[np.void], claimed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    torn = np.zeros(len(rows), bool)
    if "checksum" in (rows.dtype.names or ()):
        tasks = np.flatnonzero(claimed)
        for start in range(0, len(tasks), _CHUNK):
            some = tasks[start : start + _CHUNK]
            torn[some] = ~is_sealed(_as_row(rows[some]))
    return torn


def _as_row(rows: NDArray[np.void]) -> NDArray[np.void]:
    """Our columns as they were sealed, whatever other columns stand between them."""
    names = rows.dtype.names or ()
    layout = next((one for one in LAYOUTS.values() if ("checked" in (one.names or ())) == ("checked" in names)), ROW)
    packed = np.zeros(len(rows), layout)
    for name in layout.names or ():
        if name in names:
            packed[name] = rows[name]
    return packed


def _frame(
    rows: NDArray[np.void], keep: NDArray[np.bool_], torn: NDArray[np.bool_], known: NDArray[np.bool_]
) -> pd.DataFrame:
    """The rows to `keep`; of those that are not `known` nothing but what they were to be."""
    columns: dict[str, Any] = {}
    blank = np.flatnonzero(~known[keep])
    for name in rows.dtype.names or ():
        kind = "" if name == "checksum" else rows.dtype[name].kind  # it has told what it has to tell
        ours = name in (ROW.names or ()) and name not in (*PARAMETERS, "status")
        if kind in ("S", "O"):
            column = rows[name][keep]
            column[blank if ours else []] = b""
            columns[name] = _labels(column, torn[keep] if name == "status" else None)
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
    """What a column of numbers holds where nothing is known."""
    return np.nan if kind == "f" else NO_RANK if name == "rank" else 0


def _labels(column: NDArray[Any], torn: NDArray[np.bool_] | None = None) -> pd.Categorical:
    values = column.astype(object)
    if torn is not None:
        values[torn] = TORN_LABEL.encode()
    codes, found = pd.factorize(values, sort=True)
    # latin-1 decodes any bytes, and different ones differently: a damaged row cannot stop the reading.
    names = [value.decode("latin-1") if isinstance(value, bytes) else str(value) for value in found]
    categories: Any = pd.Index(names, dtype=str)
    return pd.Categorical.from_codes(codes, categories=categories)
