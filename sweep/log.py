"""Lines for people: on stderr while something runs, on stdout how it ended."""

import contextlib
import os
import sys


def say(line: str) -> None:
    """Write one whole line at once, so that lines of several processes do not run together."""
    with contextlib.suppress(OSError):  # a full disk under the log must not end the run
        sys.stderr.write(f"sweep: {line}\n")
        sys.stderr.flush()


def conclude(line: str) -> None:
    """Print how a run ended. A stdout that cannot be written does not change how it ended."""
    try:
        print(line, flush=True)
    except OSError:
        drop_stdout()


def drop_stdout() -> None:
    """Throw away what could not be written: Python would write it once more at its end, and fail again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
