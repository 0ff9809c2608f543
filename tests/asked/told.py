"""One command in a process of its own that has everything loaded, and what every answer is judged by."""

import contextlib
import os
import secrets
import signal
import sys
import time
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from tests.histories.commands import forked

LIMIT = 120.0  # seconds, on a machine that may be busy


class Wrong(AssertionError):  # noqa: N818 # what the program looks for
    """What an answer promises, and does not keep."""


class Told(NamedTuple):
    """How a command ended, what it said, and which files it wrote or changed."""

    line: str
    status: int
    out: str
    err: str
    wrote: frozenset[str]


def must(holds: object, what: str) -> None:
    """A promise."""
    if not holds:
        raise Wrong(what)


def tell(command: Callable[[], int], folder: Path, line: str) -> Told:
    """Run it in that folder; every warning is shown, as none may be."""
    scratch = folder.parent
    out, err = (scratch / f"{secrets.token_hex(4)}.{name}" for name in ("out", "err"))
    before = contents(folder)

    def loud() -> int:
        warnings.simplefilter("always")
        return command()

    sys.stdout.flush()
    pid, status, until = forked(loud, folder, out, err), None, time.monotonic() + LIMIT
    while status is None:
        ended, code = os.waitpid(pid, os.WNOHANG)
        status = os.waitstatus_to_exitcode(code) if ended else None
        if time.monotonic() > until:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
            raise Wrong(f"{line}: has not ended in {LIMIT:.0f} s")
        time.sleep(0.005)
    said = [each.read_text() if each.exists() else "" for each in (out, err)]
    for each in (out, err):
        with contextlib.suppress(OSError):
            each.unlink()
    after = contents(folder)
    return Told(line, status, *said, frozenset(name for name, _ in {*before.items()} ^ {*after.items()}))


def contents(folder: Path) -> dict[str, int]:
    """Every file below the folder, with its checksum."""
    return {
        str(each.relative_to(folder)): zlib.crc32(each.read_bytes()) for each in folder.rglob("*") if each.is_file()
    }
