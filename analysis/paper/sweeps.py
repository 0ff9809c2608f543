"""How a table came to be, for a reader: rows, accuracy, time."""

from pathlib import Path

import numpy as np
import pandas as pd

from analysis.searched import spec_of
from analysis.table import checked, finished, flagged, load, reused_text, status_counts, unchecked_text, wall_seconds
from sweep.errors import InputError


def history(path: Path) -> dict[str, str]:
    """A table's name, rows by status, share of chaos, accuracy asked for, estimated errors and time.

    A row that was taken over from another table keeps the seconds it took there, and no table marks such rows.
    """
    df = load(path, done_only=False)
    done = finished(df)
    return {
        "table": path.stem,
        "rows": status_counts(df["status"]),
        "chaotic": _chaotic(done),
        "accuracy": _accuracy(path),
        "error": _errors(done),
        "seconds": _seconds(path, done),
    }


def _chaotic(done: pd.DataFrame) -> str:
    known = done[checked(done)]
    parts = [f"{flagged(known).sum()} ({100 * flagged(known).mean():.1f} %)"] if len(known) else []
    return "; ".join([*parts, *filter(None, [unchecked_text(done)])]) or "none"


def _accuracy(path: Path) -> str:
    try:
        asked = spec_of(path)["accuracy"]
    except (InputError, KeyError):
        return "not stated in the table"
    return f"target {asked['target']:g}, method {asked['method']}"


def _errors(done: pd.DataFrame) -> str:
    known = done.loc[~flagged(done) & np.isfinite(done["error"]), "error"]
    if known.empty:
        return "not estimated"
    return f"median {known.median():.1g}, 95 % below {known.quantile(0.95):.1g}"


def _seconds(path: Path, done: pd.DataFrame) -> str:
    wall, core, taken = wall_seconds(path), float(done["seconds"].sum()), reused_text(path)
    text = f"{core:.0f} s of computing" + (f", its own and that of {taken}" if taken else "")
    return text + ("" if wall is None else f", {wall:.0f} s of wall time")
