"""Tells people and `sweep status` how far a run is."""

import contextlib
import platform
import sys
import time

import numpy as np

from sweep.batches import Batches
from sweep.master import Count
from sweep.schema import RUN
from sweep.writers import Writer

LOG_EVERY = 30.0  # seconds between lines: people follow the log with tail
RECORD_EVERY = 1.0  # seconds between updates of the table's list of runs


class Progress:
    """Called by the master all the while; speaks and records at its own pace."""

    def __init__(self, writer: Writer, slot: int, batches: Batches, count: Count, run: np.ndarray) -> None:
        """`slot`, `run` (shape (1,), dtype table.RUN): this run's row in the table's list of runs."""
        self._writer, self._slot, self._batches, self._count, self._run = writer, slot, batches, count, run
        self._started = time.monotonic()
        self._recorded, self._logged = self._started - RECORD_EVERY, self._started

    def tick(self) -> None:
        """Record and speak if it is time to."""
        now = time.monotonic()
        if now - self._recorded >= RECORD_EVERY:
            self.record()
            self._recorded = now
        if now - self._logged >= LOG_EVERY:
            self._log(now - self._started)
            self._logged = now

    def record(self) -> None:
        """Write this run's row into the table."""
        self._run["updated"] = time.time()
        self._run["left"] = self._run["left_at_start"] - self._count.done - self._count.failed
        self._run["work_left"] = self._batches.seconds_left
        self._writer.log(self._slot, self._run)

    def end(self) -> None:
        """Record that nothing more comes."""
        self._run["ended"] = True
        self.record()

    def _log(self, elapsed: float) -> None:
        all_work, left_work = float(self._run["work_left_at_start"][0]), self._batches.seconds_left
        done = self._count.done + self._count.failed
        share = 1.0 - left_work / all_work
        eta = f"{elapsed * (1 / share - 1):.0f} s" if share > 0 else "unknown"
        of = int(self._run["left_at_start"][0])
        say(f"{done} of {of} tasks, {self._count.failed} failed, {elapsed:.0f} s, about {eta} left")


def new_run(
    left: int, work_left: float, ranks: int, writer: str, kernel: str, hosts: str = "", job: str = ""
) -> np.ndarray:
    """A row for the list of runs, shape (1,)."""
    run = np.zeros(1, RUN)
    run["start"] = run["updated"] = time.time()
    run["left"] = run["left_at_start"] = left
    run["work_left"] = run["work_left_at_start"] = work_left
    run["ranks"], run["writer"], run["kernel"], run["host"] = ranks, writer, kernel, platform.node()[:64]
    run["hosts"], run["job"] = hosts, job[:64]
    return run


def say(line: str) -> None:
    """One whole line at once, so that lines of several processes do not run together."""
    with contextlib.suppress(OSError):  # a full disk under the log must not end the run
        sys.stderr.write(f"sweep: {line}\n")
        sys.stderr.flush()
