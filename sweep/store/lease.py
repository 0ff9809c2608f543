"""Who holds a table, written into its lock file again and again: the sign of life that other nodes see."""

import contextlib
import json
import os
import platform
import threading
import time
import uuid
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from sweep.store import disk

BEAT = 5.0  # seconds between two signs of life
LEASE_MAX = 75.0  # seconds without one after which the holder counts as dead
HOLD_MAX = 60.0  # seconds without one after which the holder itself stops, a while before others may begin
SETTLE = 3.0  # seconds in which a lease written by another node at the same time is seen
WIDTH = 256  # bytes of a lease in the file


@dataclass(frozen=True)
class Lease:
    """One sign of life."""

    host: str
    process: int
    boot: str  # of the holder's system: names of hosts may repeat
    token: str  # of the holder
    beat: int = 0
    time: float = 0.0  # seconds since 1970 by the holder's clock, for people

    @property
    def is_here(self) -> bool:
        """Whether the holder is of this node, whose locks tell whether it lives."""
        return (self.host, self.boot) == (platform.node(), _boot())

    def is_of(self, other: "Lease | None") -> bool:
        """Whether both were written by one run."""
        return other is not None and self.token == other.token


def new() -> Lease:
    """A lease of this process."""
    return Lease(platform.node()[:64], os.getpid(), _boot(), uuid.uuid4().hex, 0, time.time())


def _boot() -> str:
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return ""


def read(path: Path) -> Lease | None:
    """The lease in a lock file; None where there is none, or it is just being written."""
    try:
        disk.forget_what_was_read(path)
        return Lease(**json.loads(path.read_text()))
    except (OSError, ValueError, TypeError):
        return None


def write(descriptor: int, lease: Lease) -> None:
    """Put a lease into an open lock file."""
    os.pwrite(descriptor, json.dumps(asdict(lease)).ljust(WIDTH).encode(), 0)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in disk.CANNOT_FLUSH:
            raise


def needs_settling(path: Path, found: Lease | None) -> bool:
    """Whether another node may have written a lease at the same time, so that one of the two must step back."""
    return disk.is_shared(path.parent) or not (found is None or found.is_here)


class Keeper:
    """A thread that keeps a lease alive, and notices when it is lost."""

    def __init__(self, path: Path, descriptor: int, lease: Lease, lost: Callable[[str], None]) -> None:
        self._path, self._descriptor, self._lease, self._lost = path, descriptor, lease, lost
        self._shared = disk.is_shared(path.parent)  # else no other node can take it, however late a beat is
        self._ending, self._alive = threading.Event(), time.monotonic()
        self._thread = threading.Thread(target=self._run, name="lease", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._ending.wait(BEAT):
            self._beat()

    def _beat(self) -> None:
        found = read(self._path)
        if found is not None and not self._lease.is_of(found):
            self._lost(f"a run on {found.host} (process {found.process}) has taken the table over")
            return
        self._lease = replace(self._lease, beat=self._lease.beat + 1, time=time.time())
        with contextlib.suppress(OSError):
            write(self._descriptor, self._lease)
            if not self._shared or time.monotonic() - self._alive < HOLD_MAX:
                self._alive = time.monotonic()
        if self._shared and time.monotonic() - self._alive > HOLD_MAX:
            self._lost(f"the lease of the table could not be renewed for {HOLD_MAX:.0f} s")

    def close(self) -> bool:
        """Let it go; whether the file may be closed: a disk that is gone may hold the thread that writes it."""
        self._ending.set()
        self._thread.join(BEAT)
        return not self._thread.is_alive()
