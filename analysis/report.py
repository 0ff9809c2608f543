"""The lines that a command prints: which rows it used, and the lowest ratio."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from analysis.best import guessed_below, lowest_row
from analysis.checks import model_axes
from analysis.notes import Notes, count, known_text
from analysis.quantity import Quantity
from analysis.table import (
    CELL,
    finished,
    flagged,
    looked_for_chaos,
    reasons_text,
    status_counts,
    unchecked_text,
    unchecked_words,
)


def rows_used(
    table: pd.DataFrame,
    used: pd.DataFrame,
    cells: pd.DataFrame,
    notes: Notes,
    over: Sequence[str] = tuple(CELL),
    what: str = "row",
) -> list[str]:
    """How many rows were used and why the others were not.

    `table` holds all rows, `used` those that competed for a cell, `cells` those that are drawn, `notes` what the
    picture says about them; `what` they are: rows of the table, or the candidates of `analysis.sought`.
    """
    done = finished(table)
    no_ratio = int((~np.isfinite(done[notes.of.ratio])).sum())
    left_out = [f"{no_ratio} without {notes.of.ratio}"]
    if looked_for_chaos(done):
        left_out.append(f"{len(done) - no_ratio - len(used)} chaotic in cells that have other rows")
    return [
        _rows(table, what),
        f"used      {len(used)} finished {what}s; left out: {', '.join(left_out)}",
        f"cells     {_filled(cells, over, notes)}; {_chaos(cells, notes)}",
    ]


def rows_lines(table: pd.DataFrame, used: str, part: Mapping[str, str]) -> list[str]:
    """The lines on what the table holds and what of it was used; then those of `part`."""
    return [_rows(table), f"used      {used}", *part_lines(part)]


def part_lines(part: Mapping[str, str]) -> list[str]:
    """A line for each sentence, as of `analysis.part.part_of`, behind its word."""
    return [f"{word:9} {text}" for word, text in part.items() if text]


def used_of_lines(found: pd.DataFrame, reasons: Mapping[str, int]) -> str:
    """How many rows the lines used, how many were left out by `reasons`, as of `left_out`, and how many not checked.

    `found` is what `transition` or `crossings` gives: a row per line, with its counts.
    """
    rows, unchecked = (int(found[name].sum()) for name in ("rows", "unchecked"))
    texts = f"{rows} rows", f"left out: {reasons_text(reasons)}", unchecked_words(unchecked, rows)
    return "; ".join(filter(None, texts))


def lines_without(found: pd.DataFrame) -> str:
    """How many lines have no result, by reason: "; 3 never above 1" for example; empty where all have one."""
    lost = found.loc[found["why_not"] != "", "why_not"].value_counts()
    return "".join(f"; {count} {why}" for why, count in lost.items())


def _rows(table: pd.DataFrame, what: str = "row") -> str:
    counted = len(table) if what == "row" else count(len(table), what)
    return f"rows      {counted}: {status_counts(table['status'])}"


def plane_used(
    table: pd.DataFrame, cells: pd.DataFrame, drawn: pd.DataFrame, over: Sequence[str], notes: Notes
) -> list[str]:
    """The same for a plane of the grid, which leaves out unfinished rows only; `drawn`: cells, with those inferred."""
    between = len(drawn) - len(cells)
    inferred = f"; {between} more inferred" if between else ""
    return [_rows(table), f"cells     {_filled(cells, over, notes, drawn)}{inferred}; {_chaos(cells, notes)}"]


def _chaos(cells: pd.DataFrame, notes: Notes) -> str:
    """Which cells are hatched, and how many were not checked; "hatched: none" only where some were."""
    shown = cells[cells[notes.of.ratio].notna()]
    hatched = f"hatched: {notes.hatched or 'none'}" if notes.hatched or looked_for_chaos(shown) else ""
    return "; ".join(filter(None, (hatched, unchecked_text(shown))))


def lowest(cells: pd.DataFrame, notes: Notes, what: str = "cell") -> list[str]:
    """The lowest ratio of the cells, or of `what` else they are, and where it is, as analysis.best.lowest_row has it.

    A line before it says how many chaotic ones go lower.
    """
    of = notes.of
    top = lowest_row(cells, chaotic_too=notes.chaotic_too, of=of)
    if flagged(top)[0]:
        return [f"lowest    {_lowest_text(top, of)}"]
    lower = cells[flagged(cells) & (cells[of.ratio] < top[of.ratio].iloc[0]).to_numpy()]
    are = f"{count(len(lower), what)} {'is' if len(lower) == 1 else 'are'} lower"
    more = [f"chaotic   {are}, down to {_lowest_text(lowest_row(lower, of=of), of)}"] if len(lower) else []
    guesses = guessed_below(cells, top, of)
    return [*more, f"lowest    {_lowest_text(top, of)}", *([f"inferred  {guesses}"] if guesses else [])]


def left_out_lower(used: pd.DataFrame, table: pd.DataFrame, of: Quantity, what: str = "row") -> list[str]:
    """A line on the chaotic rows that were left out and are lower than all that competed."""
    done = finished(table)
    others = done[~done.index.isin(used.index)]
    lower = others[(others[of.ratio] < used[of.ratio].min()).to_numpy() & flagged(others)]
    if lower.empty:
        return []
    are = f"{count(len(lower), what)} left out {'is' if len(lower) == 1 else 'are'} lower"
    return [f"chaotic   {are} (--chaotic-too), down to {_lowest_text(lowest_row(lower, of=of), of)}"]


def _filled(cells: pd.DataFrame, over: Sequence[str], notes: Notes, drawn: pd.DataFrame | None = None) -> str:
    shown = cells if drawn is None else drawn
    places = pd.concat([shown[list(over)], *([] if notes.absent is None else [notes.absent[list(over)]])])
    grid = places[over[0]].nunique() * places[over[1]].nunique()
    return f"{cells[notes.of.ratio].notna().sum()} of {grid} have a number"


def _lowest_text(one: pd.DataFrame, of: Quantity) -> str:
    row = one.iloc[0]
    model = "".join(f", {name} = {row[name]:.4g}" for name in model_axes(one))
    return (
        f"{of.ratio} = {row[of.ratio]:.4g} ({known_text(one, of)}) at N = {row['N']}, "
        f"zeta_T = {row['zeta_T']:.4g}, M/M0 = {row['M_over_M0']:.4g}, V/V0 = {row['V_over_V0']:.4g}{model}"
    )
