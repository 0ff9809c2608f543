"""One run per table: a lock file beside it, which the system releases when the holder dies, and in it a lease.

On many disks the lock is known on the holder's node only, and on others it outlives a node that died by a minute. So
the lock file also says who holds it, and the holder rewrites it all the while (`lease`): whoever finds the lease of
another node watches it by a clock of its own, and takes the table over only if it does not change for LEASE_MAX.
"""

import fcntl
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from sweep.errors import InputError
from sweep.log import say
from sweep.store import lease
from sweep.store.lease import LEASE_MAX, Lease

TRIES_MAX, TRY_EVERY = 5, 0.02  # tries, seconds: whoever asks `is_held` has the lock for a moment too
LOOK_EVERY = 1.0  # seconds between looks at another node's lease


@contextmanager
def only_run(table: Path, lost: Callable[[str], None] = lambda _: None) -> Iterator[None]:
    """Hold the lock of `table`; InputError where another run holds it or the folder cannot be written.

    `lost` is called, from another thread, where another node has taken the table over meanwhile.
    """
    path = _place(table)
    descriptor, ours = _acquired(table, path)
    keeper = lease.Keeper(path, descriptor, ours, lost)
    try:
        yield
    finally:
        let_go = keeper.close()
        if ours.is_of(lease.read(path)):
            path.unlink(missing_ok=True)
        if let_go:
            os.close(descriptor)


def _acquired(table: Path, path: Path) -> tuple[int, Lease]:
    """The lock, with a lease of ours in it."""
    tries, ours, seen = 0, lease.new(), _Seen()
    while True:
        descriptor = _opened(table, path)
        try:
            locked = _locked(table, descriptor)
            found = lease.read(path)
            dead = found is None or found.is_here or seen.is_dead(found, locked)
            if locked and dead and _is_still(descriptor, path) and _leased(path, descriptor, found, ours):
                kept, descriptor = descriptor, -1
                return kept, ours
        finally:
            if descriptor >= 0:
                os.close(descriptor)
        if found is None or found.is_here:
            tries += 1
            if not locked and tries >= TRIES_MAX:
                there = f"{table}: another run is writing this table"
                raise InputError(f"{there}; wait for it, help it by `sweep join`, or stop it")
            time.sleep(TRY_EVERY)
        else:
            seen.refuse_living(table, found)
            time.sleep(LOOK_EVERY)


def _opened(table: Path, path: Path) -> int:
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(f"{table}: its folder cannot be written: {error.strerror}") from None


def _locked(table: Path, descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        raise InputError(f"{table}: its file system has no locks ({error.strerror}); use another") from None
    return True


def _leased(path: Path, descriptor: int, found: Lease | None, ours: Lease) -> bool:
    """Write our lease; whether it stays, where nodes without a common lock may do so at the same time.

    Every node that wants a table reads before it writes. Whoever still finds its own lease a while after is alone.
    """
    try:
        lease.write(descriptor, ours)
    except OSError as error:
        raise InputError(f"{path.parent}: the lock of a table cannot be written there: {error.strerror}") from None
    if lease.needs_settling(path, found):
        time.sleep(lease.SETTLE)
    return ours.is_of(lease.read(path))


class _Seen:
    """What was seen of another node's lease."""

    def __init__(self) -> None:
        self._lease: Lease | None = None
        self._since, self._denied = 0.0, 0

    def is_dead(self, found: Lease, locked: bool) -> bool:
        """Whether it has not changed for LEASE_MAX, or its lock, which was seen from here, has been let go."""
        self._look(found)
        self._denied += not locked
        return (locked and self._denied >= TRIES_MAX) or time.monotonic() - self._since > LEASE_MAX

    def refuse_living(self, table: Path, found: Lease) -> None:
        """InputError where its holder lives, or a dead holder's lock does not end."""
        where = f"{table}: a run on {found.host} (process {found.process})"
        if self._look(found):
            raise InputError(f"{where} is writing this table; wait for it or stop it")
        if time.monotonic() - self._since > 2.0 * LEASE_MAX:
            raise InputError(f"{where} is dead, but its file system still holds its lock; try again later")

    def _look(self, found: Lease) -> bool:
        """Whether the holder has given a sign of life since the first look."""
        alive = self._lease is not None and found != self._lease
        if self._lease is None:
            say(f"a run on {found.host} holds this table; waiting up to {LEASE_MAX:.0f} s for a sign of life from it")
            self._lease, self._since = found, time.monotonic()
        return alive


def is_held(table: Path) -> bool:
    """Whether a run holds the lock of `table`. Of a run on another host only some file systems know."""
    return is_locked(_place(table), unknown=False)


def is_locked(path: Path, unknown: bool) -> bool:
    """Whether a process holds a lock of this file; `unknown`: the answer where the file system cannot tell."""
    try:
        with path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except FileNotFoundError:
        return False
    except OSError:
        return unknown
    return False


def real(table: Path) -> Path:
    """The path behind a link, so that a new table replaces the old table and not the link."""
    return Path(os.path.realpath(table)) if os.path.islink(table) else table  # noqa: PTH114


def _place(table: Path) -> Path:
    path = Path(os.path.realpath(table))  # two names of one table share the lock
    return path.with_name(f".{path.name}.lock")


def _is_still(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
