"""The table of a search: what the search has learnt from it, and which of its tasks are still needed."""

from collections import Counter
from pathlib import Path

import h5py
import numpy as np

from sweep.errors import InputError
from sweep.plan.search import Search
from sweep.plan.tasks import Ids
from sweep.schema import RESULTS, SCREENED, UNASKED, is_screened
from sweep.store import table


def search_of(file: h5py.File, sampler: Path | None = None) -> Search | None:
    """The search of a table, with nothing learnt; None where it is a plain grid or list.

    sampler: the file that steers it, if it is the user's own; without, it asks for nothing. InputError where
    the provenance is damaged.
    """
    resolved = table.resolved(file)
    if not is_searched(resolved):
        return None
    from sweep.plan.asked import section_of  # pydantic, which the workers of a run do without
    from sweep.plan.spec import read_axes

    try:
        section = section_of(resolved)
        search = section.search(read_axes(resolved.get("grid")), sampler) if section else None
    except (ValueError, KeyError):
        search = None
    if search is None or len(search.tasks) != len(file[RESULTS]) or search.screens != (SCREENED in file):
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
    for first in range(0, len(finished), table.ROWS_AT_ONCE):
        part = slice(first, first + table.ROWS_AT_ONCE)
        ids = first + np.flatnonzero(finished[part])
        search.tell(ids, file[RESULTS][part][ids - first])
        if search.screens:
            rows = file[SCREENED][part]
            ids = first + np.flatnonzero(is_screened(rows))
            search.tell_screened(ids, rows["value"][ids - first])
    return search.ask(), search


def counts(file: h5py.File) -> tuple[Counter[str], int]:
    """How many rows ended with which status, and how many orders are left, as far as a search knows."""
    ended = table.kinds(file)
    return ended, len(file[RESULTS]) - ended.total() if search_of(file) is None else len(left(file)[0])


def screened(file: h5py.File) -> int | None:
    """How many tasks were screened; None where none ever is."""
    if SCREENED not in file:
        return None
    parts = range(0, len(file[SCREENED]), table.ROWS_AT_ONCE)
    return sum(int(is_screened(file[SCREENED][k : k + table.ROWS_AT_ONCE]).sum()) for k in parts)


def mark(search: Search, file: h5py.File) -> None:
    """In a new table, mark the rows that the search does not begin with: they may never be computed."""
    results, first = file[RESULTS], search.ask()
    for begin in range(0, len(results), table.ROWS_AT_ONCE):
        rows = results[begin : begin + table.ROWS_AT_ONCE]
        rows["status"][~np.isin(np.arange(begin, begin + len(rows)), first)] = UNASKED
        results[begin : begin + len(rows)] = rows
