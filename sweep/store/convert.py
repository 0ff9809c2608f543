"""A table of an earlier version, written anew as this one writes its rows."""

from pathlib import Path

import h5py

from sweep.errors import InputError
from sweep.log import say
from sweep.plan.tasks import TaskList
from sweep.schema import RESULTS, RUNS
from sweep.store import table


def convert(path: Path, tasks: TaskList) -> None:
    """Replace the table at `path` by one of today's layout, where it is older; its lock is held.

    Every row, run and text of provenance is kept; the new table takes the old one's place only when complete.
    """
    with table.reading(path) as old:
        if not table.is_older(old):
            return

        def fill(file: h5py.File) -> None:
            for part, rows in table.chunks(old):
                file[RESULTS][part] = rows
            file[RUNS][...] = old[RUNS][...]

        try:
            table.create(path, tasks, table.attributes(old), fill)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    say(f"{path}: was written by an earlier version; its rows now say whether they were checked for chaos")
