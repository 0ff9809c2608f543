"""A table that is too large for memory, read part by part: the rows that `--at` fixes, or the best of every cell.

Of the best only the winners so far are kept.
"""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.best import best
from analysis.chain import told_of
from analysis.checks import require
from analysis.marks import FAILED, NOT_COMPUTED
from analysis.notes import Notes, hatched_best, left_out_text
from analysis.part import failed_text, waiting_text
from analysis.plane import check_names, missing, same
from analysis.quantity import KE, Quantity
from analysis.reading import frame_of, is_csv, refuse_no_file, torn_rows
from analysis.table import CELL, DONE_LABEL, IMPACT, flagged, no_finished_row, unchecked_words
from sweep.errors import InputError
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, PENDING, RESULTS, is_ended, today
from sweep.store.table import attributes, reading, statuses, written
from sweep.store.unwritten import grid_of, is_unwritten, pending

ROWS_MAX = 1 << 24  # of a table that is read whole: 4 GB of memory as a data frame


@dataclass(frozen=True)
class Best:
    """What `analysis best` shows of a large grid, and the counts that it prints."""

    cells: pd.DataFrame  # as of analysis.best.best
    impacts: dict[str, NDArray[np.float64]]
    notes: Notes
    lines: list[str]


def grid_of_large(path: str) -> Tasks | None:
    """The tasks of the table where it is a grid too large to be read whole; None of a damaged one, too."""
    if is_csv(path):
        return None
    refuse_no_file(Path(path))
    if not h5py.is_hdf5(path):
        return None
    try:
        with h5py.File(path, "r", locking=False) as file:
            rows = file.get(RESULTS)
            if not isinstance(rows, h5py.Dataset) or len(rows) <= ROWS_MAX:
                return None
    except (OSError, RuntimeError):  # whoever reads its rows says so
        return None
    with reading(Path(path)) as file:
        return grid_of(attributes(file), len(file[RESULTS]))


def rows_at(path: Path, grid: Tasks, at: Mapping[str, float]) -> pd.DataFrame:
    """All rows with these values, as `analysis.load(path, done_only=False)` has them.

    InputError where the grid has no such value, or where more than ROWS_MAX rows have these.
    """
    check_names(list(at), list(grid.axes))
    places = {name: np.flatnonzero(same(grid.axes[name], value)) for name, value in at.items()}
    if problems := [
        missing(grid.axes[name], name, at[name], "task") for name, found in places.items() if not len(found)
    ]:
        raise InputError(*problems)
    count = math.prod(len(places.get(name, axis)) for name, axis in grid.axes.items())
    if count > ROWS_MAX:  # before a number is made for each of them
        some = f"{count} of its {len(grid)} rows" if at else f"its {len(grid)} rows"
        raise InputError(f"{path}: {some} are more than the {ROWS_MAX} that are read at once: fix parameters by --at")
    ids = grid.product(places)
    rows = _rows(path, grid, ids)
    claimed = rows["status"] != PENDING
    torn = torn_rows(rows, claimed)
    return frame_of(rows, np.ones(len(rows), bool), torn, claimed & ~torn).set_index(pd.Index(ids, name="task"))


def _rows(path: Path, grid: Tasks, ids: NDArray[np.int64]) -> NDArray[np.void]:
    with reading(path) as file:
        rows = pending(grid.columns(ids), today(file[RESULTS].dtype))
        for part, some in written(file):
            here = slice(*np.searchsorted(ids, (part.start, part.stop)))
            found = some[ids[here] - part.start]
            there = ~is_unwritten(found)
            rows[here][there] = found[there]
    return rows


def best_of_grid(path: str, grid: Tasks, chaotic_too: bool, of: Quantity = KE) -> Best:
    """The lowest row of every cell, with what is known of the others; InputError where no row is finished."""
    kinds, winners, counts = Counter[str](), pd.DataFrame(), pd.DataFrame()
    with reading(Path(path)) as file:
        for part, rows in written(file):
            ended = is_ended(rows)
            kinds.update(statuses(rows[ended]))
            done = ended & (rows["status"] == DONE)
            df = frame_of(rows, done, np.zeros(len(rows), bool), done)
            require(df, (of.ratio, of.error))
            df.index += part.start
            if len(df := df[np.isfinite(df[of.ratio])]):
                winners, counts = _winners(winners, df, of), _counts(counts, df)
    if winners.empty:
        raise no_finished_row(path, pd.Series([*kinds.elements()] or ["pending"]))
    cells = best(winners, chaotic_too=chaotic_too, of=of.ratio)
    told = _told(grid, kinds, cells, counts, chaotic_too, of, told_of(path, winners))
    return Best(cells, {name: grid.axes[name] for name in IMPACT}, *told)


def _winners(before: pd.DataFrame, df: pd.DataFrame, of: Quantity) -> pd.DataFrame:
    """The lowest row of every cell, and the lowest that is not chaotic: one of them wins, whatever else there is."""
    rows = pd.concat([before, df]) if len(before) else df
    calm = rows[~flagged(rows)]
    each = [best(some, chaotic_too=True, of=of.ratio) for some in (rows, calm) if len(some)]
    return rows.loc[np.unique(np.concatenate([one.index for one in each]))]


def _counts(before: pd.DataFrame, df: pd.DataFrame) -> pd.DataFrame:
    """Of every cell how many rows have a number, and how many of them are chaotic or were not checked."""
    new = df[CELL].assign(rows=1, chaotic=flagged(df), unchecked=~df["checked"].to_numpy(bool)).groupby(CELL).sum()
    return new if before.empty else before.add(new, fill_value=0)


def _told(
    grid: Tasks,
    kinds: Counter[str],
    cells: pd.DataFrame,
    counts: pd.DataFrame,
    chaotic_too: bool,
    of: Quantity,
    chain: str,
) -> tuple[Notes, list[str]]:
    rows, unchecked = int(counts["rows"].sum()), int(counts["unchecked"].sum())
    calm = counts["rows"] - counts["chaotic"]
    chaotic, waiting = int(counts["chaotic"].sum()), len(grid) - kinds.total()
    left_out = 0 if chaotic_too else int(counts["chaotic"][calm > 0].sum())
    failed = kinds.total() - kinds[DONE_LABEL]
    part = waiting_text(waiting, len(grid)), failed_text(failed, len(grid))
    notes = Notes(
        hatched_best(cells, chaotic_too),
        " ".join(filter(None, (*part, chain, left_out_text(left_out, chaotic, rows)))),
        unchecked_words(unchecked, rows, "row"),
        _absent(grid, cells, kinds),
        chaotic_too,
        of,
        waiting + failed > 0,
    )
    others = "".join(f", {n} {word}" for word, n in sorted(kinds.items()) if word != DONE_LABEL)
    places = len(grid.axes["N"]) * len(grid.axes["zeta_T"])
    return notes, [
        f"rows      {len(grid)}: {kinds[DONE_LABEL]} done{others}, {waiting} pending or torn",
        f"used      {rows - left_out} finished rows; left out: {kinds[DONE_LABEL] - rows} without {of.ratio}, "
        f"{left_out} chaotic in cells that have other rows",
        f"cells     {len(cells)} of {places} have a number; hatched: {notes.hatched or 'none'}"
        f"{'; ' * bool(notes.unchecked)}{notes.unchecked}",
    ]


def _absent(grid: Tasks, cells: pd.DataFrame, kinds: Counter[str]) -> pd.DataFrame:
    """The cells without a number: not computed, or failed where every row of the table has ended."""
    every = pd.MultiIndex.from_product([grid.axes[name] for name in CELL], names=CELL)
    lost = every.difference(pd.MultiIndex.from_frame(cells[CELL])).to_frame(index=False)
    return lost.assign(fate=FAILED if kinds.total() == len(grid) else NOT_COMPUTED)
