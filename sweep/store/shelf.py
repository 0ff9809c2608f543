"""Rows of many sweeps in one SQLite file, found by what they are: what `--store DIR` keeps. Knows no sweep.

Several runs may read and write it at once, and be killed: SQLite locks it, and undoes what was not finished. It keeps a
rollback journal, never a write-ahead log, whose readers and writers must share the memory of one machine.
"""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError
from sweep.plan.tasks import Columns, inputs
from sweep.schema import inputs_of, is_sealed
from sweep.store import disk

FILE = "rows.sqlite"
OURS, LAYOUT = 0x62735357, 1  # by which SQLite's header tells our files, and the tables in them
BUSY_MAX = 60.0  # seconds that another run may write before this one gives up: it writes for milliseconds
PAGE = (
    8192  # bytes: half of it makes look-ups slower by a half, twice as many what a batch of rows writes (tests.stores)
)
AT_ONCE = 1000  # keys of one question to SQLite, which takes 32 766; more of them are no faster (tests.stores)
# Bits of a key that tell tasks of one chain apart; those above bring such rows together, so that a batch of them
# changes few pages. Of ten million rows a thousand to each chain, two get one key in one store out of a thousand.
CHAIN, TASK_BITS = ("N", "zeta_T"), 43
TABLES = """
CREATE TABLE IF NOT EXISTS kinds (kind INTEGER PRIMARY KEY, what TEXT UNIQUE NOT NULL);
CREATE TABLE IF NOT EXISTS origins (origin INTEGER PRIMARY KEY, place TEXT UNIQUE NOT NULL);
CREATE TABLE IF NOT EXISTS rows
    (key INTEGER PRIMARY KEY, kind INTEGER NOT NULL, origin INTEGER NOT NULL, row BLOB NOT NULL);
"""


class Taken(NamedTuple):
    """Rows that were found."""

    where: NDArray[np.int64]  # in what was asked for
    rows: NDArray[np.void]
    origins: NDArray[np.int64]  # where each comes from (`Shelf.place_of`)


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
            raise InputError(f"--store {self.path.parent}: {FILE} cannot be used: {error}") from None

    def _begin(self) -> None:
        run = self._file.execute
        (ours,), (layout,) = run("PRAGMA application_id").fetchone(), run("PRAGMA user_version").fetchone()
        empty = run("SELECT count(*) FROM sqlite_schema").fetchone() == (0,)
        if (ours, layout) != (OURS, LAYOUT) and not empty:
            raise InputError(f"--store {self.path.parent}: {FILE} is no store of this version of bistable-sweep")
        (journal,) = run("PRAGMA journal_mode = DELETE").fetchone()
        if journal != "delete":
            raise InputError(f"--store {self.path.parent}: {FILE} keeps its journal as {journal}, must be delete")
        if empty:
            run(f"PRAGMA page_size = {PAGE}")
            run("BEGIN IMMEDIATE")  # another run may do so at the same time
            for line in (*TABLES.split(";"), f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {LAYOUT}"):
                run(line)
            run("COMMIT")

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
        """Of tasks with these inputs the intact rows that there are, in the order of the tasks."""
        wanted = keys_of(kind, columns)
        ascending = np.sort(wanted)  # neighbours lie on one page
        keys, origins, rows = list[int](), list[int](), list[bytes]()
        with self._told():
            for first in range(0, len(ascending), AT_ONCE):
                for key, origin, row in self._some(kind, ascending[first : first + AT_ONCE].tolist()):
                    keys.append(key)
                    origins.append(origin)
                    rows.append(row)
        size = layout.itemsize
        raw = b"".join(row if len(row) == size else bytes(size) for row in rows)  # of nothing but zeros: never sealed
        found = np.frombuffer(raw, layout)
        return _intact(np.array(keys, np.int64), found, np.array(origins, np.int64), wanted, columns)

    def _some(self, kind: int, keys: list[int]) -> list[tuple[int, int, bytes]]:
        marks = ", ".join("?" * len(keys))
        question = f"SELECT key, origin, row FROM rows WHERE key IN ({marks}) AND kind = ?"
        return self._file.execute(question, [*keys, kind]).fetchall()

    def put(self, kind: int, origin: int, rows: NDArray[np.void]) -> None:
        """Keep sealed rows, in place of what had their keys: a killed run leaves all of them or none."""
        keys = keys_of(kind, {name: rows[name] for name in inputs_of(rows.dtype)}).tolist()
        whole = ((key, kind, origin, row.tobytes()) for key, row in zip(keys, rows, strict=True))
        with self._told():
            self._file.execute("BEGIN IMMEDIATE")
            try:
                self._file.executemany("INSERT OR REPLACE INTO rows VALUES (?, ?, ?, ?)", whole)
                self._file.execute("COMMIT")
            except BaseException:
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


def keys_of(kind: int, columns: Columns) -> NDArray[np.int64]:
    """A number from 0 to 2**63 for every task; two tasks have the same one hardly ever, which readers must check."""
    task = chain = _stirred(np.zeros(len(columns["N"]), np.uint64), np.uint64(kind))
    for name in inputs(columns):
        values = np.asarray(columns[name])
        bits = values.astype(np.float64).view(np.uint64) if values.dtype.kind == "f" else values.astype(np.uint64)
        task = _stirred(task, bits)
        chain = _stirred(chain, bits) if name in CHAIN else chain
    low = task & np.uint64(2**TASK_BITS - 1)
    return (((chain >> np.uint64(TASK_BITS + 1)) << np.uint64(TASK_BITS)) | low).astype(np.int64)


def _stirred(known: NDArray[np.uint64], bits: NDArray[np.uint64] | np.uint64) -> NDArray[np.uint64]:
    """The finaliser of splitmix64, each of whose bits depends on all of its input's."""
    mixed = (known ^ bits) + np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return mixed ^ (mixed >> np.uint64(31))


def _intact(
    keys: NDArray[np.int64],
    rows: NDArray[np.void],
    origins: NDArray[np.int64],
    wanted: NDArray[np.int64],
    columns: Columns,
) -> Taken:
    """Rows that were found, without those that are damaged, or of another task of the same key."""
    ascending = np.argsort(keys)
    there = keys[ascending]
    place = np.searchsorted(there, wanted)
    where = np.flatnonzero(np.append(there, -1)[place] == wanted)  # several tasks may be one
    place = ascending[place[where]]
    good = is_sealed(rows)[place]
    for name in inputs_of(rows.dtype):
        good &= rows[name][place] == np.asarray(columns[name])[where]
    place = place[good]
    whole = rows.view(f"V{rows.itemsize}")[place].view(rows.dtype)  # not column by column
    return Taken(where[good], whole, origins[place])
