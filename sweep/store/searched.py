"""The table of an adaptive sweep: what the search has learnt from its rows, and which of them are still needed."""

from collections import Counter

import h5py
import numpy as np

from sweep.errors import InputError
from sweep.plan.adaptive import Search
from sweep.plan.tasks import Ids
from sweep.schema import RESULTS, UNASKED
from sweep.store import table


def search_of(file: h5py.File) -> Search | None:
    """The search of an adaptive sweep's table, with nothing learnt; None where it is a plain grid or list.

    InputError where the provenance is damaged.
    """
    resolved = table.resolved(file)
    if "adaptive" not in resolved:
        return None
    from sweep.plan.spec import Adaptive, Grid  # pydantic, which the workers of a run do without

    try:
        grid, asked = Grid.model_validate(resolved.get("grid")), Adaptive.model_validate(resolved["adaptive"])
        search = Search(grid.model_dump(), asked.rule())
    except ValueError:
        search = None
    if search is None or len(search.tasks) != len(file[RESULTS]):
        raise InputError(f"{file.filename}: its provenance does not tell its search")
    return search


def left(file: h5py.File, retry_failed: bool = False) -> tuple[Ids, Search | None]:
    """The tasks to be computed next, and the search for further ones where there is one."""
    finished, search = table.finished(file, retry_failed), search_of(file)
    if search is None:
        return np.flatnonzero(~finished), None
    for first in range(0, len(finished), table.ROWS_AT_ONCE):
        ids = first + np.flatnonzero(finished[first : first + table.ROWS_AT_ONCE])
        search.learn(ids, file[RESULTS][first : first + table.ROWS_AT_ONCE][ids - first])
    return search.wanted(), search


def counts(file: h5py.File) -> tuple[Counter[str], int]:
    """How many rows ended with which status, and how many are left, as far as an adaptive sweep knows."""
    ended = table.kinds(file)
    return ended, len(file[RESULTS]) - ended.total() if search_of(file) is None else len(left(file)[0])


def mark(search: Search, file: h5py.File) -> None:
    """In a new table, mark the rows that the search does not begin with: they may never be computed."""
    results, first = file[RESULTS], search.first
    for begin in range(0, len(results), table.ROWS_AT_ONCE):
        rows = results[begin : begin + table.ROWS_AT_ONCE]
        rows["status"][~np.isin(np.arange(begin, begin + len(rows)), first)] = UNASKED
        results[begin : begin + len(rows)] = rows
