"""What the table of a search tells: what was looked for, and which of its rows were computed."""

from collections.abc import Collection
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.quantity import KE
from analysis.reading import is_csv, opened
from analysis.table import DONE_LABEL, TO_COME, UNASKED_LABEL, checked
from sweep.errors import InputError
from sweep.schema import ROW, SCREENED, SCREENED_PER_TASK, SCREENED_ROW, is_screened
from sweep.store import provenance, searched
from sweep.store.table import PROVENANCE, attributes, reading


def search_of(path: str | Path) -> dict[str, Any] | None:
    """The section of a table's spec that told what to find; None of a table of all rows, and of a CSV."""
    section = spec_of(path).get("search")
    return section if isinstance(section, dict) else None


def spec_of(path: str | Path) -> dict[str, Any]:
    """The spec of a table with every default; empty of a CSV, or where a table does not tell it."""
    resolved = known_of(path).get("resolved")
    return resolved if isinstance(resolved, dict) else {}


def known_of(path: str | Path) -> dict[str, Any]:
    """Where a table comes from (sweep.store.provenance); empty of a CSV, and of people's own tables."""
    if is_csv(path):
        return {}
    with opened(path) as file:
        return provenance.read(attributes(file)) if PROVENANCE in file else {}


def screened(path: str | Path) -> NDArray[np.float64]:
    """What screening gave for every row (n,), nan where it gave nothing; empty where nothing is screened."""
    with opened(path) as file:
        data = file.get(SCREENED)
        there = isinstance(data, h5py.Dataset)
        rows = data[: len(data) // SCREENED_PER_TASK] if there else np.empty(0, SCREENED_ROW)
    return np.where(is_screened(rows), rows["value"], np.nan)


def said(path: str | Path, table: pd.DataFrame, drawn: str | None = None) -> str:
    """A sentence on what a search has looked at, for the small print of a picture; empty where all rows were asked for.

    `table` holds all rows; `drawn`: the column of a map that shows what is inferred between the computed rows too,
    where it is what the search asks about. None of what shows computed rows alone.
    """
    status = table["status"].astype(str)
    computed = int((~status.isin(TO_COME)).sum())
    if not (status == UNASKED_LABEL).any():
        return ""
    ended = "" if _left(path) == 0 else " It has not ended."
    search = search_of(path)
    if search is None or search.get("find") not in ("lowest", "map"):
        return f"A search: {computed} of {len(table)} rows computed, the others not asked for.{ended}"
    if search.get("find") == "map":
        if drawn != search.get("of"):
            alone = "; only these are shown" if drawn is None else f", of which alone {drawn} is known"
            known = f"{computed} of {len(table)} rows computed{alone}"
            return f"A search for a map of {search.get('of')}: {known}.{ended}"
        off = f"asked for to {search.get('error')} of their logarithm"
        how = "interpolated"
        if search.get("screen"):
            how = "run once, loosely, and corrected by what is interpolated between the computed ones"
        known = "whether these are chaotic is not known"
        known += ", and no number is told where all computed ones near are chaotic or failed"
        return (
            f"A search: {computed} of {len(table)} rows computed (dots); the others are {how}, {off}; {known}.{ended}"
        )
    with opened(path) as file:
        found = searched.seen(file)
    seen = found.screened if found else 0
    looked = f"A search: {seen} of {len(table)} rows screened, which is coarse and not certified"
    return f"{looked}; {computed} that may be the lowest of their cell computed. Only these are shown.{ended}"


def _left(path: str | Path) -> int:
    """How much the search still asks for; 0 where the file cannot tell."""
    try:
        with reading(Path(path)) as file:
            return len(searched.left(file)[0])
    except InputError:
        return 0


def certified(path: str | Path, rows: pd.DataFrame) -> pd.DataFrame:
    """The rows, of a search for the lowest without those that were computed and say nothing of their chaos."""
    if (search_of(path) or {}).get("find") != "lowest":
        return rows
    return rows[checked(rows) | (rows["status"].astype(str) != DONE_LABEL).to_numpy()]


def looked_over(path: str | Path) -> list[str]:
    """The axes over which a search looked for the lowest: its rows compete along these; none of any other table."""
    search = search_of(path) or {}
    return list(search.get("over") or ()) if search.get("find") == "lowest" else []


def apart(path: str | Path, cells: Collection[str]) -> str:
    """A sentence that a search looked for the lowest over an axis whose values are apart here; empty where none is.

    cells: the axes of a picture, and those that are fixed at one of several values.
    """
    over = looked_over(path)
    if not (names := [name for name in over if name in cells]):
        return ""
    one = " and one ".join(names)
    lower = f"at one {one} a row may be lower that was not computed"
    return f"It looked for the lowest over all {', '.join(over)}: {lower}."


def has_seen_all(path: str | Path, cells: Collection[str]) -> bool:
    """Whether a search for the lowest has ended, over nothing that is apart here (as of `apart`)."""
    return bool(looked_over(path)) and not apart(path, cells) and _left(path) == 0


def refuse_another(path: str | Path, of: str) -> None:
    """InputError where a search looked for the lowest of something else: its rows say nothing of the lowest of `of`."""
    search = search_of(path)
    if search is not None and search.get("find") == "lowest" and search.get("of") != of:
        found = search.get("of")
        ours = found == KE.ratio or found not in (ROW.names or ())
        shown = f"`analysis best --of {found}`" if ours else "`analysis page`"
        raise InputError(
            f"{path}: is a search for the lowest {found}, which tells nothing of {of}; {shown} shows its rows"
        )
