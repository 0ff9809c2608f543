"""A folder beside a table, through which a run gives work to processes that joined it later (`sweep join`).

No connection is needed, only the disk that both see. Every file has one writer and one reader:

    run             the run's sign of life (`lease`)
    GUEST.guest     a guest's; GUEST is its random token
    bits            is there where the run keeps rows for other sweeps, and so asks which bits its guests compute
    GUEST.bits      the answer (kernel.numerics), there before the guest's sign
    GUEST.kind      the kind of its processor (sweep.machine), there before its sign, too
    GUEST.K.order   its K-th work: the inputs of some tasks, and as which rank it computes
    GUEST.K.rows    what came of it: finished, sealed rows of its first tasks; those of the next ones come
                    under the same name once these were taken

Orders and rows appear under their names when they are complete. Whoever gives a sign of life rewrites it every few
seconds and holds a lock of the file: on its own node its death is seen at once, from others after LEASE_MAX without
a sign. A disk that does not answer for a while tells nothing: both ends look again. The run alone writes the table, and
takes in rows only if they are whole and of the tasks that it ordered. So a guest may die at any instant, or be taken
for dead: its tasks are computed by somebody else, and what it sends later is thrown away. If the run dies the guests
end, and the next run begins with an empty folder. The worst of it is that some tasks are computed twice; as a row's
bits do not depend on who computed it, the table's do not either.
"""

import contextlib
import fcntl
import os
import shutil
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sweep.store import lease
from sweep.store.lease import LEASE_MAX, Lease
from sweep.store.lock import is_locked

RUN, GUEST, ORDER, ROWS, BITS, KIND = "run", ".guest", ".order", ".rows", "bits", "kind"


def folder_of(table: Path) -> Path:
    """Where the guests of the run that writes this table find their work."""
    real = Path(os.path.realpath(table))
    return real.with_name(f".{real.name}.join")


def put(path: Path, rows: NDArray[np.void]) -> int:
    """Write an order, or rows, that appears only when complete; how many. OSError where that cannot be."""
    partial = path.with_name(f"{path.name}.partial")
    with partial.open("wb") as file:
        np.save(file, rows, allow_pickle=False)
    partial.replace(path)
    return len(rows)


def get(path: Path) -> NDArray[np.void] | None:
    """What lies there, which is then gone; None where there is nothing.

    DamagedError where it is not whole; OSError where the disk does not answer, which may pass.
    """
    try:
        rows: NDArray[np.void] = np.load(path, allow_pickle=False)
    except FileNotFoundError:
        return None
    except (ValueError, EOFError) as error:  # of a disk that lost what was written
        _remove(path)
        raise DamagedError(f"{path}: damaged ({error})") from None
    _remove(path)
    return rows


def said(path: Path) -> str:
    """The text that lies there; nothing where none does."""
    with contextlib.suppress(OSError, ValueError):
        return path.read_text()
    return ""


def _remove(path: Path) -> None:
    """What stays is never asked for again, and goes with the folder."""
    with contextlib.suppress(OSError):
        path.unlink(missing_ok=True)


class DamagedError(Exception):
    """An order, or rows, that cannot be read and never will be."""


class Sign:
    """This process's sign of life, kept by a thread until it is closed."""

    def __init__(self, path: Path, ours: Lease | None = None) -> None:
        ours, self._path, hidden = ours or lease.new(), path, path.with_name(f"{path.name}.partial")
        self._descriptor = os.open(hidden, os.O_RDWR | os.O_CREAT, 0o666)
        with contextlib.suppress(OSError):  # where there are no locks, the signs are seen
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        lease.write(self._descriptor, ours)
        hidden.replace(path)
        self._keeper = lease.Keeper(path, self._descriptor, ours, lambda _: None)

    def close(self) -> None:
        """Take it away: this process ends."""
        _remove(self._path)
        if self._keeper.close():
            os.close(self._descriptor)


class Watched:
    """Another process's sign of life, watched by this process's clock."""

    def __init__(self, path: Path) -> None:
        self._path, self._since = path, time.monotonic()
        self._lease: Lease | None = None

    def is_gone(self) -> bool:
        """Whether it has died, or ended, or has given no sign for LEASE_MAX."""
        try:
            self._path.stat()
        except FileNotFoundError:
            return True
        except OSError:  # the disk does not answer
            return time.monotonic() - self._since > LEASE_MAX
        found = lease.read(self._path)
        if found is not None and found != self._lease:
            self._lease, self._since = found, time.monotonic()
        if time.monotonic() - self._since > LEASE_MAX:
            return True
        # On a disk without locks only the signs tell.
        return found is not None and found.is_here and not is_locked(self._path, unknown=True)


def empty(folder: Path) -> None:
    """Make the folder anew, without what an earlier run has left there; OSError where that cannot be."""
    remove(folder)
    folder.mkdir(exist_ok=True)


def remove(folder: Path) -> None:
    """Take the folder away, under another name first: a guest that writes meanwhile would keep it there."""
    going = folder.with_name(f"{folder.name}.gone")
    shutil.rmtree(going, ignore_errors=True)
    with contextlib.suppress(OSError):
        folder.rename(going)
    for each in (going, folder):
        shutil.rmtree(each, ignore_errors=True)


def names(folder: Path, ending: str) -> list[str]:
    """The files with this ending that the disk shows now, without it."""
    with contextlib.suppress(OSError):
        return sorted(path.name.removesuffix(ending) for path in folder.iterdir() if path.name.endswith(ending))
    return []
