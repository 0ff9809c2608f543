"""Which part of its sweep a table holds: what a search has computed, one shard, what a run has come to so far."""

import math
from collections.abc import Collection
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.searched import known_of, said, spec_of
from analysis.table import TO_COME, UNASKED_LABEL, has_failed, pairs_of
from sweep.plan.spec import read_axes
from sweep.store.table import CHOSEN

Axes = dict[str, NDArray[np.float64]]
CHOSEN_TEXT = "Merged from a search, which has chosen its rows: those that it left out are in no table."


def part_of(path: str | Path, table: pd.DataFrame, rows: pd.DataFrame, drawn: str | None = None) -> dict[str, str]:
    """Sentences on what a table lacks, by the word that begins their printed line; empty where it lacks nothing.

    table: all its rows; rows: those with the values that --at fixes; drawn: as of `analysis.searched.said`.
    """
    status = rows["status"].astype(str)
    waiting = int((status.isin(TO_COME) & (status != UNASKED_LABEL)).sum())
    found = {
        "search": said(path, table, drawn),
        "shard": shard_of(path, len(table)),
        "chosen": CHOSEN_TEXT if CHOSEN in known_of(path) else "",
        "pending": waiting_text(waiting, len(rows)),
        "failed": failed_text(int(has_failed(rows).sum()), len(rows)),
    }
    return {word: text for word, text in found.items() if text}


def shard_of(path: str | Path, held: int) -> str:
    """A sentence that a table of `held` rows is a shard; empty of a whole one, and of a CSV, which does not tell."""
    if (name := known_of(path).get("shard")) is None:
        return ""
    total = math.prod(map(len, axes_of(path).values()))
    share = f"{held} of its {total} rows" if total > held else f"{held} of its rows"
    return f"Shard {name} of a sweep: {share}; the others are in other tables."


def waiting_text(waiting: int, rows: int) -> str:
    """A sentence on the rows that a run has yet to compute; empty without any."""
    return f"{waiting} of {rows} rows are yet to be computed." if waiting else ""


def failed_text(failed: int, rows: int) -> str:
    """A sentence on the rows that have ended without a number; empty without any."""
    return f"{failed} of {rows} rows failed." if failed else ""


def gaps_text(rows: pd.DataFrame) -> str:
    """A sentence that impacts lack of some chains, as where those that a search chose were merged; empty of a grid."""
    held, pairs = pairs_of(rows)
    return f"No full grid: {held} of {pairs} pairs of a chain and an impact have a row." if held < pairs else ""


def axes_of(path: str | Path, fixed: Collection[str] = ()) -> Axes:
    """All values of every axis of the spec's grid, but of those that are fixed; empty where a table tells no grid."""
    try:
        axes = read_axes(spec_of(path).get("grid"))
    except (ValueError, KeyError, TypeError):
        return {}
    return {name: np.array(values) for name, values in axes.items() if name not in fixed}
