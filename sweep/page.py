"""`sweep run --page`: the table's page, made anew while the sweep runs, by a program of its own.

Rank 0 starts `analysis page` and does not wait for it: neither it nor any worker loads what draws.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

from sweep.log import say
from sweep.site import launch

FIRST, REST = 5.0, 20.0  # seconds before the first page; of its duration, before the next
LAST_LIMIT = 600.0  # seconds that the last page may take
ALONE = {"MPI4PY_RC_INITIALIZE": "0"}  # the program leaves MPI alone


class Page:
    """Keeps `page` as the table at `path` is; with no `page` it does nothing. Leaving the block makes the last one."""

    def __init__(self, page: Path | None, path: Path) -> None:
        self._page, self._path = page, path
        self._running: subprocess.Popen[str] | None = None
        self._started: float
        self._next = time.monotonic() + FIRST

    def __enter__(self) -> "Page":
        return self

    def tick(self) -> None:
        """Start another one where it is time to; called again and again."""
        now = time.monotonic()
        if self._page is None or now < self._next:
            return
        if self._running is None:
            self._start()
        elif self._running.poll() is not None:
            self._finish()
            self._next = now + max(FIRST, REST * (now - self._started))

    def hurry(self) -> None:
        """Make no last one: the job is about to be ended."""
        self._leave()
        self._page = None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._leave()  # it shows less than the last one
        if self._page is not None and kind is None:
            self._start()
            if self._finish():
                say(f"page {self._page}")

    def _start(self) -> None:
        command = [sys.executable, "-P", "-m", "analysis", "page", str(self._path), "-o", str(self._page)]
        none, pipe = subprocess.DEVNULL, subprocess.PIPE
        ours = launch.without_launcher(os.environ) | ALONE
        self._started = time.monotonic()
        try:  # in a session of its own: a Ctrl-C is for the sweep
            self._running = subprocess.Popen(
                command, stdin=none, stdout=none, stderr=pipe, text=True, env=ours, start_new_session=True
            )
        except OSError as error:
            say(f"page {self._page}: not made ({error.strerror})")
            self._next = self._started + FIRST

    def _finish(self) -> bool:
        """Wait for a page; whether it was made. Without it the table is as good."""
        if self._running is None:
            return False
        running, self._running = self._running, None
        try:
            _, told = running.communicate(timeout=LAST_LIMIT)
        except subprocess.TimeoutExpired:
            running.kill()
            running.communicate()
            told = f"not made within {LAST_LIMIT:.0f} s"
        if running.returncode:
            say(f"page {self._page}: {(told.strip().splitlines() or ['not made'])[-1]}")
        return running.returncode == 0

    def _leave(self) -> None:
        if self._running is not None:
            self._running.kill()
            self._running.communicate()
            self._running = None
