"""Load a results table (HDF5) as a data frame, and say what its rows are."""

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import error_of, inputs, model_axes, truth
from analysis.quantity import KE, Quantity
from analysis.reading import TORN_LABEL, check_columns, frame_of, labels, opened, read_rows, torn_rows
from kernel.hints import shown
from sweep.errors import InputError
from sweep.schema import DONE, PENDING, RESULTS, RUN, RUNS, SCREENED, UNASKED, was_checked
from sweep.store.table import possible

CELL, IMPACT = ["N", "zeta_T"], ["M_over_M0", "V_over_V0"]  # the parameters of the chain, and of what strikes it
DONE_LABEL, PENDING_LABEL, UNASKED_LABEL = (word.decode() for word in (DONE, PENDING, UNASKED))
AGAIN = "of a task with a better row"  # why a row does not count, as `left_out` tells it
# Rows that are still to be computed, a torn one again: they have not failed.
AWAITED = (PENDING_LABEL, TORN_LABEL, "")
TO_COME = (*AWAITED, UNASKED_LABEL)


def load(path: str | os.PathLike[str], done_only: bool = True) -> pd.DataFrame:
    """The rows of a table, one per task.

    Parameters
    ----------
    path : str or path-like
        A table that `sweep run` or `sweep merge` has written, or is writing: its unfinished rows are not done. What
        `sweep.run` returns is one too.
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
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> calm = df[df["checked"] & ~df["chaotic"].fillna(True)]    # what is known not to be chaotic
    >>> len(calm) <= len(df)
    True
    """
    truth("done_only", done_only)
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path: must be the path of a table, got {shown(path)}")
    path = Path(path)
    rows = read_rows(path)
    check_columns(rows.dtype, path)
    status = np.asarray(rows["status"])
    claimed = (status != PENDING) & (status != UNASKED)
    torn = torn_rows(rows, claimed)
    if not done_only:
        return frame_of(rows, np.ones(len(rows), bool), torn, claimed & ~torn)
    keep = (status == DONE) & ~torn
    if not keep.any():
        raise no_finished_row(path, labels(status, torn))
    return frame_of(rows, keep, torn, keep)


def wall_seconds(path: str | Path) -> float | None:
    """Wall time of all runs that touched the table, in seconds; None where the table does not say."""
    runs = _run_log(path, "start", "updated")
    if runs is None:
        return None
    known = possible(runs)
    return float(np.sum(known["updated"] - known["start"]))


def reused(path: str | Path) -> dict[str, int]:
    """From which tables or stores (`sweep run --reuse, --store`) how many rows were taken over; empty where the table
    does not say. What was only screened is no row.
    """
    from sweep.store.reuse import reused as of_other_tables  # readers of rows alone do without

    taken, runs = Counter[str](), _run_log(path, *(RUN.names or ()))
    for one in [] if runs is None else of_other_tables(runs):
        if not one["accuracy"].startswith(SCREENED):
            taken[one["table"]] += one["rows"]
    return taken


def _run_log(path: str | Path, *columns: str) -> Any:
    """The table's log of runs; None where it has none, or not these columns."""
    with opened(path) as file:
        runs = file.get(RUNS)
        return runs[()] if isinstance(runs, h5py.Dataset) and {*columns} <= {*(runs.dtype.names or ())} else None


def reused_text(path: str | Path) -> str:
    """For example "12 of 24 rows taken over from old.h5"; empty where there are none."""
    if not (taken := reused(path)):
        return ""
    with opened(path) as file:
        done = np.count_nonzero(file[RESULTS]["status"] == DONE)
    return f"{sum(taken.values())} of {done} rows taken over from {', '.join(taken)}"


def with_optional(df: pd.DataFrame, names: Sequence[str], of: Quantity = KE) -> list[str]:
    """The names, and those optional columns that the frame has."""
    return [*names, *(name for name in ("checked", *of.spread) if name in df)]


def finished(df: pd.DataFrame) -> pd.DataFrame:
    """The done rows of a frame; all of them where the frame has no `status`."""
    if "status" in df and not (done := df["status"] == DONE_LABEL).all():
        df = df[done]
    return df


def has_failed(df: pd.DataFrame) -> NDArray[np.bool_]:
    """Which rows (n,) have ended without a number; none of a frame without `status`."""
    if "status" not in df:
        return np.zeros(len(df), bool)
    return ~df["status"].astype(str).isin((*TO_COME, DONE_LABEL)).to_numpy()


class LineRows(NamedTuple):
    """The rows of one combination of inputs: the `done` ones, those that `failed`, and those `to_come`."""

    done: pd.DataFrame
    failed: pd.DataFrame
    to_come: pd.DataFrame


def done_lines(df: pd.DataFrame, names: list[str]) -> Iterator[tuple[dict[str, Any], LineRows]]:
    """Every combination of these inputs that has done rows, with its rows but those that a search did not ask for."""
    failed = has_failed(df)
    to_come = df["status"].astype(str).isin(AWAITED).to_numpy() if "status" in df else np.zeros(len(df), bool)
    others = [(none, dict(iter(some.groupby(names)))) for some, none in ((df[x], df[:0]) for x in (failed, to_come))]
    for key, line in finished(df).groupby(names):
        yield dict(zip(names, key, strict=True)), LineRows(line, *(by_key.get(key, none) for none, by_key in others))


def pairs_of(df: pd.DataFrame, whole: pd.DataFrame | None = None) -> tuple[int, int]:
    """How many pairs of a chain and an impact have a row, and how many there are with all impacts of the `whole`.

    Of a grid all have one, whatever became of it. Where a search, a sample or a user chose the rows they do not.
    """
    chain = [*CELL, *model_axes(df)]
    impacts = (df if whole is None else whole)[IMPACT].drop_duplicates()
    return len(df[[*chain, *IMPACT]].drop_duplicates()), len(df[chain].drop_duplicates()) * len(impacts)


def has_number(rows: pd.DataFrame, column: str, above: float = -np.inf) -> NDArray[np.bool_]:
    """Which rows (n,) have a finite number in this column, above so much."""
    numbers = rows[column].to_numpy(float, na_value=np.nan)
    return np.asarray(np.isfinite(numbers) & (numbers > above))


def once(rows: pd.DataFrame, column: str) -> pd.DataFrame:
    """Of rows of one task that with the smallest estimated error of this column; of equal ones the lowest.

    A table has each task once; frames of two sweeps put together, one loose and one tight, may not.
    """
    known = inputs(rows)
    if not rows.duplicated(known).any():
        return rows
    error = next((rows[name] for name in (error_of(column), "error") if name in rows), np.nan)
    told = rows.assign(error=error, value=rows[column], place=np.arange(len(rows))).sort_index(kind="stable")
    kept = told.sort_values(["error", "value"], kind="stable").drop_duplicates(known)
    return rows.iloc[np.sort(kept["place"].to_numpy())]


def left_out(df: pd.DataFrame, column: str, above: float = -np.inf, chaotic_too: bool = False) -> dict[str, int]:
    """How many rows do not count, by reason, as every command tells it: no row has two.

    Those to come, by status; failed; done without a number `above` so much; of a task of which another row counts;
    chaotic, where any row was checked, but where chaotic ones count too.
    """
    status = df["status"].astype(str) if "status" in df else pd.Series(dtype=str)
    waiting = {label or "without status": int((status == label).sum()) for label in TO_COME}
    done = finished(df)
    every = done[has_number(done, column, above)]
    numbers = once(every, column)
    without, again = len(done) - len(every), len(every) - len(numbers)
    return {
        **{label: count for label, count in waiting.items() if count},
        "failed": int(has_failed(df).sum()),
        **({f"without {column}{_above(above)}": without} if without else {}),
        **({AGAIN: again} if again else {}),
        **({} if chaotic_too or not looked_for_chaos(numbers) else {"chaotic": int(flagged(numbers).sum())}),
    }


def reasons_text(reasons: Mapping[str, int]) -> str:
    """For example "2 failed, 10 chaotic"."""
    return ", ".join(f"{count} {why}" for why, count in reasons.items())


def _above(least: float) -> str:
    return f" above {least:g}" if np.isfinite(least) else ""


def with_ratio(df: pd.DataFrame, column: str) -> pd.DataFrame:
    """The finished rows that have a ratio, a finite number above 0, each task once; InputError where there are none."""
    done = finished(df)
    rows = once(done[has_number(done, column, 0)], column)
    if rows.empty:
        above = " above 0" if np.isfinite(done[column]).any() else ""
        raise InputError(f"no finished row has a {column}{above}")
    return rows


def calm_line(
    line: pd.DataFrame, along: str, column: str, above: float = -np.inf
) -> tuple[pd.DataFrame, dict[str, int]]:
    """The rows of a line with a number that are not chaotic, in the order of an axis, one for each value; and counts.

    The counts are the `rows`, how many of them are `unchecked` for chaos, and of those that are left out the `chaotic`
    ones, and the ones `without` a number `above` so much in this column.
    """
    every = line[has_number(line, column, above)]
    numbers = every if every[along].is_unique else once(every, column)  # which looks at all inputs
    chaotic = flagged(numbers)
    calm = numbers[~chaotic].sort_values(along)
    unchecked = int(np.count_nonzero(~checked(calm)))
    counts = {"rows": len(calm), "chaotic": int(chaotic.sum()), "unchecked": unchecked}
    return calm, counts | {"without": len(line) - len(every)}


def no_number(line: pd.DataFrame, counts: Mapping[str, int], column: str, above: float = -np.inf) -> str:
    """That no row of a line with these counts has a number; empty where one has."""
    return f"without {column}{_above(above)}" if counts["without"] == len(line) else ""


def flagged(df: pd.DataFrame) -> NDArray[np.bool_]:
    """Which rows are known to be chaotic, (n,); a row that was not checked is not among them."""
    return df["chaotic"].eq(True).fillna(False).to_numpy(dtype=bool)


def checked(df: pd.DataFrame) -> NDArray[np.bool_]:
    """Which rows (n,) were checked for chaos; without a column `checked` those with an estimated error or a flag."""
    if "checked" in df:
        return df["checked"].eq(True).fillna(False).to_numpy(dtype=bool)
    error = df["error"].to_numpy(float, na_value=np.nan) if "error" in df else np.full(len(df), np.nan)
    return was_checked(error, flagged(df))


def looked_for_chaos(df: pd.DataFrame) -> bool:
    """Whether any row was checked for chaos; if none was, nobody knows how many are chaotic."""
    return bool(checked(df).any() or flagged(df).any())


def unchecked_text(df: pd.DataFrame, what: str = "") -> str:
    """How many rows were not checked for chaos, in words; empty where all were. what: "row" beside counts of cells."""
    return unchecked_words(int(np.count_nonzero(~checked(df))), len(df), what)


def unchecked_words(count: int, rows: int, what: str = "") -> str:
    """The same from the two counts."""
    if not count or count == rows:
        return "not checked for chaos" if count else ""
    counted = f" {what}{'' if count == 1 else 's'}" if what else ""
    return f"{count}{counted} not checked for chaos"


def status_counts(status: "pd.Series[Any] | pd.Categorical") -> str:
    """For example "120 done, 3 failed, 77 pending": the done rows first."""
    counts = pd.Series(status).astype(str).value_counts()
    order = sorted(counts.index, key=lambda label: (label != DONE_LABEL, label))
    return ", ".join(f"{counts[label]} {label or 'without status'}" for label in order)


def no_finished_row(path: str | Path, status: "pd.Series[Any] | pd.Categorical") -> InputError:
    """The error for a table from which nothing can be drawn; it says what the rows are instead."""
    return InputError(f"{path} has no finished row ({status_counts(status) or 'no rows at all'})")
