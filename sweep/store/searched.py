"""The table of a search: what the search has learnt from it, and which of its tasks are still needed."""

from collections import Counter
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from sweep.errors import InputError, writing
from sweep.plan.search import Search
from sweep.plan.tasks import Ids
from sweep.schema import (
    DONE,
    RESULTS,
    REUSED,
    SCREENED,
    SCREENED_PER_TASK,
    SCREENED_ROW,
    UNASKED,
    is_ended,
    is_screened,
    text_of,
    whole,
)
from sweep.store import table
from sweep.store.unwritten import pending


class Seen(NamedTuple):
    """How many tasks of a search were looked at without being computed."""

    screened: int
    tried: int

    def in_words(self) -> str:
        """`9 screened, 3 tried`; the latter only where any were."""
        return f"{self.screened} screened" + (f", {self.tried} tried" if self.tried else "")


def search_of(file: h5py.File, sampler: Path | None = None) -> Search | None:
    """The search of a table, with nothing learnt; None where it is a plain grid or list.

    sampler: the file that steers it, if it is the user's own; without, it asks for nothing. InputError where
    the provenance is damaged.
    """
    resolved = table.resolved(file)
    if not is_searched(resolved):
        return None
    section = resolved.get("search")
    if isinstance(section, dict) and section.get("find") == "map" and "round" not in section:
        name = file.filename
        raise InputError(
            f"{name}: an earlier version has chosen its rows by another rule; --reuse {name} with another -o"
        )
    from sweep.plan.asked import section_of  # pydantic, which the workers of a run do without
    from sweep.plan.spec import read_axes

    try:
        asked = section_of(resolved)
        search = asked.search(read_axes(resolved.get("grid")), sampler) if asked else None
    except InputError:  # of a sampler
        raise
    except (ValueError, KeyError):
        search = None
    rows, seen = len(file[RESULTS]), len(file[SCREENED]) if SCREENED in file else 0
    if search is None or len(search.tasks) != rows or seen != (search.screens > 0) * SCREENED_PER_TASK * rows:
        raise InputError(f"{file.filename}: its provenance does not tell its search")
    return search


def is_searched(resolved: dict[str, object]) -> bool:
    """Whether a table of this resolved spec holds a search, and not all tasks."""
    return "adaptive" in resolved or "search" in resolved


def left(file: h5py.File, retry_failed: bool = False, sampler: Path | None = None) -> tuple[Ids, Search | None]:
    """The orders to be given next, and the search for further ones where there is one; `sampler`: of `search_of`."""
    finished, search = table.finished(file, retry_failed), search_of(file, sampler)
    if search is None:
        return np.flatnonzero(~finished), None
    for part in table.parts(0, len(finished)):
        places = np.flatnonzero(finished[part])
        search.tell(part.start + places, file[RESULTS][part][places])
    for part in table.parts(0, len(file[SCREENED]) if search.screens > 0 else 0):
        rows = file[SCREENED][part]
        places = np.flatnonzero(is_screened(rows))
        search.tell_seen(len(finished) + part.start + places, rows["value"][places])
    return search.ask(), search


def counts(file: h5py.File, running: bool = False) -> tuple[Counter[str], int]:
    """How many rows ended with which status, and how many orders are left, as far as a search knows.

    running: a run writes the table. Of a search it records every second what is left, and until its first record what
    the run before it recorded stands there. To learn that from the rows takes seconds for a million of them, and is
    done where a row failed: a run that tries it again counts it as left.
    """
    ended, runs = table.kinds(file), table.runs(file)
    if not is_searched(table.resolved(file)):
        return ended, len(file[RESULTS]) - ended.total()
    runs = runs[runs["writer"] != REUSED]  # what a store gives stands after the run that took it
    if running and ended.total() == ended[text_of(DONE)] and len(runs) and not runs["ended"][-1]:
        return ended, int(runs["left"][-1])
    return ended, len(left(file)[0])


def seen(file: h5py.File) -> Seen | None:
    """How many tasks were screened, and tried; None where none ever is."""
    if SCREENED not in file:
        return None
    tasks, counts = len(file[RESULTS]), Counter[int]()
    for kind in range(SCREENED_PER_TASK):
        for part in table.parts(kind * tasks, (kind + 1) * tasks):
            counts[kind] += int(np.count_nonzero(is_screened(file[SCREENED][part])))
    return Seen(counts[0], counts[1])


def mark(search: Search, file: h5py.File) -> None:
    """In a new table, mark the rows that the search does not begin with: they may never be computed."""
    results, first = file[RESULTS], search.ask()
    for part in table.parts(0, len(results)):
        rows = results[part]
        rows["status"][~np.isin(np.arange(part.start, part.stop), first)] = UNASKED
        results[part] = rows


def mend(path: Path) -> None:
    """Write anew what of a search's table is damaged: what it does not ask for no run would write again."""
    with table.reading(path) as file:
        if (search := search_of(file)) is None:
            return
        rows = file[RESULTS][()]
        seen = file[SCREENED][()] if SCREENED in file else np.empty(0, SCREENED_ROW)
    ids = np.flatnonzero(~is_ended(rows))
    new = pending(search.tasks.columns(ids), rows.dtype)
    new["status"][~np.isin(ids, search.ask())] = UNASKED
    wrong = np.flatnonzero(whole(rows[ids]) != whole(new))
    nothing = np.zeros(len(seen), SCREENED_ROW)
    torn = np.flatnonzero(~is_screened(seen) & (whole(seen) != whole(nothing)))
    anew = {RESULTS: (ids[wrong], new[wrong]), SCREENED: (torn, nothing[torn])}
    if not any(len(places) for places, _ in anew.values()):
        return
    with writing(path), h5py.File(path, "r+") as file:
        for name, (places, its) in anew.items():
            if len(places):
                table.write_rows(file[name], places, its)
