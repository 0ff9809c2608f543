"""Rows of many sweeps in one SQLite file, found by what they are: what `--store DIR` keeps. Knows no sweep.

Several runs may read and write it at once, and be killed: SQLite locks it, and undoes what was not finished. It keeps a
rollback journal, never a write-ahead log, whose readers and writers must share the memory of one machine.
"""

import sqlite3
from bisect import bisect_left
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError
from sweep.plan.tasks import Columns
from sweep.schema import inputs_of, is_sealed, whole
from sweep.store import disk
from sweep.store.blocks import INDEX, Entries, Record, by_key, entries_of, keys_of, merged, records_of

FILE = "rows.sqlite"
OURS, LAYOUT = 0x62735357, 2  # by which SQLite's header tells our files, and the tables in them
BUSY_MAX = 60.0  # seconds that another run may write before this one gives up: it writes for milliseconds
PAGE = 16384  # bytes: with half of it random look-ups took a sixth longer, twice as many made the file larger
AT_ONCE = 128  # blocks that are fetched, then handled: few enough to stay in the processor's cache
TABLES = """
CREATE TABLE IF NOT EXISTS kinds (kind INTEGER PRIMARY KEY, what TEXT UNIQUE NOT NULL);
CREATE TABLE IF NOT EXISTS origins (origin INTEGER PRIMARY KEY, place TEXT UNIQUE NOT NULL);
CREATE TABLE IF NOT EXISTS blocks
    (kind INTEGER NOT NULL, first INTEGER NOT NULL, checksum INTEGER NOT NULL, entries BLOB NOT NULL,
    rows BLOB NOT NULL, UNIQUE (kind, first));
"""
# A block reaches up to where the next one of its kind begins.
BLOCK_OF = """
SELECT first, checksum, entries, rows FROM blocks WHERE kind = ? AND first <= ? ORDER BY first DESC LIMIT 1
"""
BEGIN_KIND = "INSERT OR IGNORE INTO blocks VALUES (?, 0, 0, x'', x'')"
PUT = """
INSERT INTO blocks VALUES (?, ?, ?, ?, ?) ON CONFLICT (kind, first) DO UPDATE
SET checksum = excluded.checksum, entries = excluded.entries, rows = excluded.rows
"""


class UselessStoreError(InputError):
    """SQLite finds the store's file damaged, or no room for it: no run need end for rows that can be computed again."""


class Taken(NamedTuple):
    """Rows that were found."""

    where: NDArray[np.int64]  # in what was asked for
    rows: NDArray[np.void]
    origins: NDArray[np.int32]  # where each comes from (`Shelf.place_of`)


class Shelf:
    """The open store. A thread needs one of its own."""

    def __init__(self, folder: Path) -> None:
        """Open it, or begin it; InputError where that cannot work."""
        self.path = folder / FILE
        _check_folder(folder)
        with self._told():
            self._file = sqlite3.connect(self.path, timeout=BUSY_MAX, isolation_level=None)
            self._begin()

    @contextmanager
    def _told(self) -> Iterator[None]:
        """What SQLite refuses is the user's to mend."""
        try:
            yield
        except sqlite3.Error as error:
            useless = getattr(error, "sqlite_errorname", "").startswith(("SQLITE_CORRUPT", "SQLITE_FULL"))
            kind = UselessStoreError if useless else InputError
            raise kind(f"--store {self.path.parent}: {FILE} cannot be used: {error}") from None

    def _begin(self) -> None:
        run = self._file.execute
        with self._transaction("BEGIN"):  # so that all three are of one time: another run may begin the same store
            (ours,), (layout,) = run("PRAGMA application_id").fetchone(), run("PRAGMA user_version").fetchone()
            empty = run("SELECT count(*) FROM sqlite_schema").fetchone() == (0,)
        if (ours, layout) != (OURS, LAYOUT) and not empty:
            raise InputError(f"--store {self.path.parent}: {FILE} is no store of this version of bistable-sweep")
        (journal,) = run("PRAGMA journal_mode = DELETE").fetchone()
        if journal != "delete":
            raise InputError(f"--store {self.path.parent}: {FILE} keeps its journal as {journal}, must be delete")
        if empty:
            run(f"PRAGMA page_size = {PAGE}")
            with self._transaction("BEGIN IMMEDIATE"):  # another run may do so at the same time
                for line in (*TABLES.split(";"), f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {LAYOUT}"):
                    run(line)

    def close(self) -> None:
        """Let it go."""
        self._file.close()

    def kind(self, what: str) -> int:
        """The number of a kind of rows, which is all that tells how they were computed."""
        return self._number("kinds", "kind", "what", what)

    def kinds(self) -> dict[int, str]:
        """All kinds of rows."""
        with self._told():
            return dict(self._file.execute("SELECT kind, what FROM kinds ORDER BY kind"))

    def origin(self, place: str) -> int:
        """The number of a place where rows were computed."""
        return self._number("origins", "origin", "place", place)

    def place_of(self, origin: int) -> str:
        """Where rows with this number come from."""
        with self._told():
            found = self._file.execute("SELECT place FROM origins WHERE origin = ?", [origin]).fetchone()
        return str(found[0]) if found else "unknown"

    def _number(self, table: str, number: str, name: str, text: str) -> int:
        with self._told():
            self._file.execute(f"INSERT OR IGNORE INTO {table} ({name}) VALUES (?)", [text])
            (found,) = self._file.execute(f"SELECT {number} FROM {table} WHERE {name} = ?", [text]).fetchone()
        return int(found)

    def find(self, kind: int, columns: Columns, layout: np.dtype[Any]) -> Taken:
        """Of tasks with these inputs the intact rows that there are, in no order."""
        wanted = keys_of(kind, columns)
        order = np.argsort(wanted)
        nothing = Taken(np.empty(0, np.int64), np.empty(0, layout), np.empty(0, INDEX["origin"]))
        keys, found = wanted[order], [nothing]
        known, until = keys.tolist(), len(keys)
        while until:
            with self._transaction("BEGIN"):
                records, begin = self._below(kind, known, until)
            asked, some = order[begin:until], entries_of(records, layout)
            if len(some.keys):
                found.append(_intact(some, keys[begin:until], asked, columns))
            until = begin
        where, rows, origins = zip(*found, strict=True)
        together = np.concatenate([*map(whole, rows)]).view(layout)
        return Taken(np.concatenate(where), together, np.concatenate(origins))

    def _below(self, kind: int, keys: list[int], until: int) -> tuple[list[Record], int]:
        """The blocks of keys[begin:until], ascending as these are, and `begin`: as many as are handled at once."""
        records = list[Record]()
        while until and len(records) < AT_ONCE:
            record = self._file.execute(BLOCK_OF, (kind, keys[until - 1])).fetchone()
            if record is None:  # nothing was ever kept
                return [], 0
            records.append(record)
            until = bisect_left(keys, record[0], 0, until)
        return records[::-1], until

    def put(self, kind: int, origin: int, rows: NDArray[np.void]) -> None:
        """Keep sealed rows, in place of what had their keys: a killed run leaves all of them or none."""
        new = by_key(kind, origin, rows, inputs_of(rows.dtype))
        keys, until = new.keys.tolist(), len(new.keys)
        with self._transaction("BEGIN IMMEDIATE"):  # what was read is what is written over
            self._file.execute(BEGIN_KIND, (kind,))
            while until:
                records, begin = self._below(kind, keys, until)
                both = merged(entries_of(records, rows.dtype), new.at(slice(begin, until)))
                firsts = [record[0] for record in records]
                self._file.executemany(PUT, ((kind, *record) for record in records_of(both, firsts)))
                until = begin

    @contextmanager
    def _transaction(self, begin: str) -> Iterator[None]:
        """All or nothing."""
        with self._told():
            self._file.execute(begin)
            try:
                yield
                self._file.execute("COMMIT")
            except BaseException:
                if self._file.in_transaction:  # else SQLite has done so
                    self._file.execute("ROLLBACK")
                raise


def _check_folder(folder: Path) -> None:
    """Make the folder where there is none. InputError where it cannot hold a store."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"--store {folder}: must be a folder, or the name of a new one ({error.strerror})") from None
    if disk.loses_writes(folder):
        raise InputError(
            f"--store {folder}: lies on {disk.kind_of(folder)}, where a node may not see what another has written; "
            "give a folder on a local disk, NFS with locks, or a parallel file system"
        )


def _intact(there: Entries, keys: NDArray[np.int64], asked: NDArray[np.int64], columns: Columns) -> Taken:
    """Rows of the tasks `asked`, whose keys ascend; none that is damaged, or of another task with the same key."""
    place = np.searchsorted(there.keys, keys)
    here = np.flatnonzero(np.append(there.keys, -1)[place] == keys)  # several tasks may be one
    where, found = asked[here], there.at(place[here])
    good = is_sealed(found.rows)
    for name in inputs_of(found.rows.dtype):
        good &= found.rows[name] == np.asarray(columns[name])[where]
    if not good.all():
        where, found = where[good], found.at(np.flatnonzero(good))
    return Taken(where, found.rows, found.origins)
