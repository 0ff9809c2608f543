"""Lines for people, on stderr."""

import contextlib
import sys


def say(line: str) -> None:
    """One whole line at once, so that lines of several processes do not run together."""
    with contextlib.suppress(OSError):  # a full disk under the log must not end the run
        sys.stderr.write(f"sweep: {line}\n")
        sys.stderr.flush()
