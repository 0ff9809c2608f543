"""Whether the file that a run writes still has its table's name: people delete, move and restore files meanwhile.

A run writes an open file, whatever becomes of its name. It would compute on, for days, into a file that nobody finds.
"""

import itertools
import os
import stat
import time
from pathlib import Path

from sweep.errors import InputError
from sweep.schema import RUN
from sweep.store import disk
from sweep.store.repair import copied
from sweep.store.writers import Waiting

LOOK_EVERY = 5.0  # seconds; what one look alone shows may pass
SHARED_FOR = 60.0  # seconds in which every look at a network's disk must show it: what it tells may be old or wrong
NOTHING = b""  # under the name
HIDDEN = (".nfs", ".fuse_hidden")  # how names begin that such disks give deleted files until they are closed


class Moved:
    """Rank 0's look at the name of the table."""

    def __init__(self, path: Path, run_at: int, waiting: Waiting) -> None:
        """`path`: of the table, which a writer has open; `run_at`: the run's row of the list of runs, offset in bytes.

        `waiting`: told of the table's disk.
        """
        self._path, self._run_at, self._waiting = path, run_at, waiting
        self._descriptor, self._shared = os.open(path, os.O_RDONLY), disk.is_shared(path.parent)
        self._looked = self._since = time.monotonic()
        self._suspect: bytes | None = None
        self.is_so = False

    def look(self) -> None:
        """Look now and then; called all the while, after the run's row was written."""
        now = time.monotonic()
        if self.is_so or now - self._looked < LOOK_EVERY:
            return
        self._looked = now
        found = self._other()
        if found is None or found != self._suspect:
            self._suspect, self._since = found, now
        else:
            self.is_so = now - self._since >= (SHARED_FOR if self._shared else LOOK_EVERY)

    def _other(self) -> bytes | None:
        """What has the name in place of the run's file: nothing, or the run's row as it stands there.

        None where it is the run's file, or the disk does not tell. Some disks of networks give a file new numbers:
        then its row changes from look to look, as the run writes it.
        """
        try:
            with self._waiting.counted():
                there = self._path.stat()
                if os.path.samestat(there, os.fstat(self._descriptor)):
                    return None
                if not stat.S_ISREG(there.st_mode):
                    return NOTHING
                disk.forget_what_was_read(self._path)
                with self._path.open("rb", buffering=0) as file:
                    return os.pread(file.fileno(), RUN.itemsize, self._run_at)
        except (FileNotFoundError, NotADirectoryError):
            return NOTHING
        except OSError:
            return None

    def refuse(self) -> None:
        """At the end of the run: InputError where it is so, with what has become of the rows."""
        try:
            if not self.is_so:
                found = self._other()
                self.is_so = found == NOTHING or (found is not None and not self._shared)
            if self.is_so:
                raise InputError(f"{self._path}: {self._fate()}")
        finally:
            os.close(self._descriptor)

    def _fate(self) -> str:
        if where := self._where():
            way = f"its rows are there: give it its name again, or -o {where}, and run again"
            return f"was moved to {where} while this run wrote it; {way}"
        deleted = "deleted" if os.fstat(self._descriptor).st_nlink == 0 else "moved or deleted"
        what = "replaced by another file" if os.path.lexists(self._path) else deleted
        names = (self._path.with_name(f"{self._path.name}.saved{k or ''}") for k in itertools.count())
        aside = next(name for name in names if not os.path.lexists(name))
        try:
            with os.fdopen(
                self._descriptor, "rb", closefd=False
            ) as file:  # no disk of a network lets it be opened anew
                copied(file, aside)
        except InputError as error:
            return f"was {what} while this run wrote it; its rows are lost ({'; '.join(error.problems)})"
        way = f"what it held is saved as {aside}: rename this to {self._path}, and run again"
        return f"was {what} while this run wrote it; {way}"

    def _where(self) -> str:
        """Where it is now; nothing where that cannot be told, or it has no name that lasts."""
        try:
            where = Path(f"/proc/self/fd/{self._descriptor}").readlink()
            if where.name.startswith(HIDDEN) or not os.path.samestat(where.stat(), os.fstat(self._descriptor)):
                return ""
        except OSError:
            return ""
        beside = where.parent == Path(os.path.realpath(self._path.parent))
        return str(self._path.with_name(where.name) if beside else where)
