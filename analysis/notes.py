"""What a map says about its rows: which are chaotic, which were not checked, and why cells have no number."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.marks import FAILED, NO_NUMBER, NOT_COMPUTED
from analysis.plane import same
from analysis.quantity import KE, Quantity
from analysis.table import (
    CELL,
    DONE_LABEL,
    TO_COME,
    UNASKED_LABEL,
    checked,
    finished,
    flagged,
    has_number,
    unchecked_text,
)

NO_ERROR = "error not estimated"
_FATES = (NOT_COMPUTED, FAILED, NO_NUMBER)  # of a cell that has several the first
_LOST = "chaotic, failed or not computed"
NO_AXES: Mapping[str, NDArray[np.float64]] = MappingProxyType({})


@dataclass(frozen=True)
class Notes:
    """Texts about the rows of a map, each empty where there is nothing to say, and what the map shows.

    `hatched` explains the hatched cells, `said` stands in the small print, `unchecked` beside the scale. `absent` holds
    the cells without a finished row and their `fate`. `chaotic_too` is whether chaotic rows compete with the others,
    `of` the quantity whose ratio is drawn. `lacking`: impacts are missing that may give a lower one.
    """

    hatched: str = ""
    said: str = ""
    unchecked: str = ""
    absent: pd.DataFrame | None = None
    chaotic_too: bool = False
    of: Quantity = KE
    lacking: bool = False


def of_best(
    table: pd.DataFrame,
    used: pd.DataFrame,
    cells: pd.DataFrame,
    chaotic_too: bool = False,
    over: Sequence[str] = tuple(CELL),
    of: Quantity = KE,
    axes: Mapping[str, NDArray[np.float64]] = NO_AXES,
    what: str = "row",
) -> Notes:
    """Of a map of the best: `table` holds all rows, `used` those that competed, `cells` the winners.

    what: what its rows are.
    """
    done = finished(table)
    rows = done[np.isfinite(done[of.ratio])]
    said = left_out_text(0 if chaotic_too else len(rows) - len(used), int(flagged(rows).sum()), len(rows), what)
    lost = absent(table, over, of, axes=axes)
    return Notes(hatched_best(cells, chaotic_too), said, unchecked_text(rows, what), lost, chaotic_too, of)


def of_plane(
    table: pd.DataFrame,
    cells: pd.DataFrame,
    over: Sequence[str],
    at: Mapping[str, float] | None = None,
    of: Quantity = KE,
    axes: Mapping[str, NDArray[np.float64]] = NO_AXES,
) -> Notes:
    """Of a map of one plane: `table` holds all rows, `cells` those that are drawn."""
    drawn = cells[cells[of.ratio].notna()]
    hatched = hatched_text(drawn) if flagged(drawn).any() else ""
    return Notes(hatched, "", unchecked_text(drawn), absent(table, over, of, at, axes), of=of)


def of_points(table: pd.DataFrame, rows: pd.DataFrame, over: Sequence[str], of: Quantity = KE) -> Notes:
    """Of rows that form no grid: `table` holds all rows, `rows` those that are drawn.

    A row that a search did not ask for is no point.
    """
    asked = table[table["status"].astype(str) != UNASKED_LABEL] if "status" in table else table
    chaotic = int(flagged(rows).sum())
    ringed = f"{chaotic} of {count(len(rows), 'point')}, chaotic: sensitive to their inputs" if chaotic else ""
    return Notes(ringed, "", unchecked_text(rows), absent(asked, over, of), of=of)


def hatched_best(cells: pd.DataFrame, chaotic_too: bool) -> str:
    """How many cells of a map of the best are hatched, and why; empty where none is."""
    only = int(flagged(cells).sum())
    why = "whose lowest row is chaotic" if chaotic_too else "with chaotic rows only"
    return f"{count(only, 'cell')} {why}" if only else ""


def hatched_text(cells: pd.DataFrame) -> str:
    """How many cells are hatched, and why."""
    return f"{int(flagged(cells).sum())} of {count(len(cells), 'cell')}, chaotic: sensitive to their inputs"


def chaos_text(rows: pd.DataFrame, how: str = "") -> str:
    """For example "2500 rows used, 60 of them chaotic (hatched)", or that they were not checked for chaos."""
    known, missing = int(checked(rows).sum()), unchecked_text(rows)
    chaotic = f"{int(flagged(rows).sum())} of them chaotic" + (f" ({how})" if how else "")
    return ", ".join(filter(None, (f"{len(rows)} rows used", chaotic if known else "", missing)))


def known_text(one: pd.DataFrame, of: Quantity = KE) -> str:
    """The estimated error of this row (1,), and what is known of its chaos."""
    error = float(one[of.error].iloc[0]) if of.error in one else np.nan
    whose = f", of {of.error_of}" if of.error_of else ""
    text = f"estimated error {error:.1g} relative{whose}" if np.isfinite(error) else NO_ERROR
    chaotic = "chaotic: sensitive to its inputs" if flagged(one)[0] else unchecked_text(one)
    return ", ".join(filter(None, (text, chaotic)))


def absent(
    table: pd.DataFrame,
    over: Sequence[str],
    of: Quantity,
    at: Mapping[str, float] | None = None,
    axes: Mapping[str, NDArray[np.float64]] = NO_AXES,
) -> pd.DataFrame:
    """The cells without a number: their two parameters and their `fate`.

    Torn rows and pending ones are yet to be computed, as is what the `axes` of a grid have and the table has not: its
    rows are in another shard. What a search did not ask for is not computed either.
    """
    if "status" not in table:
        return pd.DataFrame({name: [] for name in (*over, "fate")})
    rows = table
    for name, value in (at or {}).items():
        rows = rows[same(rows[name], value)]
    status = rows["status"].astype(str)
    done, to_come = (status == DONE_LABEL).to_numpy(), status.isin(TO_COME)
    order = np.select([done & has_number(rows, of.ratio), to_come, ~done], range(3), 3)
    least = rows[list(over)].assign(order=order).groupby(list(over))["order"].min()
    if set(over) <= set(axes):
        every = pd.MultiIndex.from_product([axes[name] for name in over], names=list(over))
        least = least.reindex(least.index.union(every), fill_value=1)
    lost = least[least > 0].reset_index()
    cells: pd.DataFrame = lost[list(over)]
    return cells.assign(fate=np.array(_FATES, object)[lost["order"].to_numpy(int) - 1])


def none_text(found: pd.DataFrame, what: str) -> str:
    """Why lines have no result, as "No transition: never above 1 on 3 lines."; empty where all have one.

    `found` is what `transition` or `crossings` gives.
    """
    lost = found.loc[found["why_not"] != "", "why_not"].value_counts()
    reasons = "; ".join(f"{why} on {count(int(n), 'line')}" for why, n in lost.items())
    return f"No {what}: {reasons}." if reasons else ""


def hidden_text(found: pd.DataFrame, what: str) -> str:
    """A sentence on lines of which rows failed: what is looked for may lie there; empty where none did."""
    lacking = int((found["failed"] > 0).sum())
    return f"On {lacking} of {count(len(found), 'line')} a {what} may hide behind rows that failed." if lacking else ""


def without_text(reasons: Mapping[str, int]) -> str:
    """A sentence on the rows that are done and have no number, of what `left_out` counts; empty where all have one."""
    return " ".join(f"Left out: {count(n, 'row')} {why}." for why, n in reasons.items() if why.startswith("without "))


def skipped_text(found: pd.DataFrame, what: str, along: str = "N") -> str:
    """How many of what was found lie between values that are no neighbours on the grid, and why; empty where none."""
    there, wide = int((found["why_not"] == "").sum()), int((found["skipped"] > 0).sum())
    lost = "chaotic, failed, not computed or without the ratio" if found["without"].any() else _LOST
    why = f"{int(found['skipped'].sum())} between are {lost}"
    return f"{wide} of {count(there, what)} lie between {along} that are no neighbours: {why}." if wide else ""


def left_out_text(left_out: int, chaotic: int, rows: int, what: str = "row") -> str:
    """How many of the rows are chaotic, and how many of these do not compete; empty where none is left out."""
    which = "and left out" if left_out == chaotic else f"and {left_out} of these left out"
    return f"{chaotic} of {count(rows, what)} are chaotic (sensitive to their inputs) {which}." if left_out else ""


def count(n: int, what: str) -> str:
    """For example "1 cell", "2 cells"."""
    return f"{n} {what}{'' if n == 1 else 's'}"
