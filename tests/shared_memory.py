"""MPICH's files in shared memory, which it cannot remove where its ranks are killed."""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

YOUNG = 10.0  # seconds: ranks that start create a file before they map it


def files() -> set[Path]:
    """Those that are there."""
    return set(Path("/dev/shm").glob("mpich_*"))


@contextlib.contextmanager
def cleared() -> Iterator[None]:
    """At the end remove what has come meanwhile, but not what ranks of a test at the same time use."""
    before = files()
    yield
    for left_over in files() - before:
        with contextlib.suppress(FileNotFoundError):
            if time.time() - left_over.stat().st_mtime > YOUNG and not _is_mapped(left_over):
                left_over.unlink()


def _is_mapped(file: Path) -> bool:
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with contextlib.suppress(OSError):  # of a process that has ended meanwhile
            if str(file) in maps.read_text():
                return True
    return False
