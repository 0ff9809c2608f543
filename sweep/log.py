"""Lines for people: on stderr while something runs, on stdout how it ended."""

import contextlib
import os
import sys
import time
from typing import Any, TextIO

BAR = "{desc} {n_fmt} of {total_fmt} |{bar}| {elapsed}"
SAY_EVERY = 10.0  # seconds between two lines while the kernel is compiled


def say(line: str) -> None:
    """Write one whole line at once, as stderr does, so that lines of several processes do not run together."""
    with contextlib.suppress(OSError):  # a full disk under the log must not end the run
        sys.stderr.write(f"sweep: {line}\n")


class Compiling:
    """Says that the kernel is compiled, and now and then how far that is: for kernel.jit.compiling."""

    def __init__(self) -> None:
        self._next = 0.0

    def __call__(self, count: int) -> None:
        """`count`: how many functions are compiled."""
        now = time.monotonic()
        if not count:
            say("compiling the kernel, once, in about a minute; the next run finds it in the cache")
        elif now >= self._next:
            say(f"compiling the kernel: {count} functions so far")
        else:
            return
        self._next = now + SAY_EVERY


class Bar:
    """How far a long command is, on a terminal; elsewhere nothing is shown."""

    def __init__(self) -> None:
        self._what = ""
        self._bar: Any = None

    def __enter__(self) -> "Bar":
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def __call__(self, what: str, done: int, of: int) -> None:
        """So much of `what` is done."""
        if not sys.stderr.isatty():
            return
        from tqdm import tqdm

        if self._bar is None or what != self._what:
            self.__exit__()
            self._what, self._bar = what, tqdm(desc=what, total=of, bar_format=BAR, leave=False, file=sys.stderr)
        self._bar.n = done
        self._bar.refresh()


def conclude(line: str) -> None:
    """Print how a run ended. A stdout that cannot be written does not change how it ended."""
    try:
        print(line, flush=True)
    except OSError:
        drop(sys.stdout)


def drop(stream: TextIO) -> None:
    """Throw away what could not be written: Python would write it once more at its end, and fail again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def settle_stderr() -> None:
    """At the end of a program, write what there was no room for, or throw it away: it does not change how it ended."""
    try:
        sys.stderr.flush()
    except OSError:
        drop(sys.stderr)
