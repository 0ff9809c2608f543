"""Shows people and `sweep status` how far a run is."""

import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sweep.log import say
from sweep.plan.batches import Batches
from sweep.serve.master import Count
from sweep.serve.worker import Usage
from sweep.store.runs import seconds_to_go
from sweep.store.writers import Writer

LOG_FIRST, LOG_EVERY = 2.0, 30.0  # seconds to the first line and, at last, between lines: the gap doubles
RECORD_EVERY = 1.0  # seconds between updates of the table's list of runs
SHARES_LISTED_MAX = 8  # ranks whose busy shares are told one by one; of more the least is
BAR = "{percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} tasks, {elapsed}{postfix}"


@dataclass(frozen=True)
class Efficiency:
    """What every rank of a whole run did with its time."""

    ranks: Sequence[Usage]
    wall: float  # seconds from the first batch to the last row
    tail: float  # seconds between the first rank running dry and the end
    predicted: float  # core seconds of the rows that were finished
    serving: float  # seconds of rank 0's core that serving took

    @property
    def shares(self) -> list[float]:
        """Busy share of every rank."""
        return [usage.busy / self.wall if self.wall > 0 else 0.0 for usage in self.ranks]

    @property
    def busy(self) -> float:
        """Seconds that all ranks together were busy."""
        return sum(usage.busy for usage in self.ranks)

    def __str__(self) -> str:
        shares, waited = self.shares, sum(usage.waited for usage in self.ranks)
        listed = len(shares) <= SHARES_LISTED_MAX
        each = " ".join(f"{share:.0%}" for share in shares) if listed else f"least {min(shares):.0%}"
        cpu = sum(usage.waited_cpu for usage in self.ranks) / waited if waited > 0 else 0.0
        return (
            f"ranks busy {sum(shares) / len(shares):.1%} ({each}), waited {waited:.2f} s at {cpu:.1%} of a core; "
            f"tail {self.tail:.2f} s; serving took {self.serving:.2f} s; "
            f"computing took {self.busy:.1f} s, predicted {self.predicted:.1f} s"
        )


class Progress:
    """Shows and records how far the run is, at intervals of its own: a bar on a terminal, else lines.

    The master calls `tick` all the while.
    """

    def __init__(
        self, writer: Writer, slot: int, batches: Batches, count: Count, run: np.ndarray, more: bool = False
    ) -> None:
        """`slot`, `run` (shape (1,), dtype schema.RUN): this run's row in the table's list of runs.

        `more`: whether finished rows lead to further tasks, so that nobody knows yet when the end is.
        """
        self._writer, self._slot, self._batches, self._count, self._run = writer, slot, batches, count, run
        self._started, self._known = time.monotonic(), int(run["left_at_start"][0])
        self._recorded, self._more = self._started - RECORD_EVERY, more
        self._next_line, self._gap = self._started + LOG_FIRST, LOG_FIRST
        self._bar = _bar(int(run["left_at_start"][0]))

    def tick(self) -> None:
        """Record and show how far the run is, where it is time to."""
        now = time.monotonic()
        if now - self._recorded >= RECORD_EVERY:
            self.record()
            self._recorded = now
        if self._bar is None and now >= self._next_line:
            self._log(now - self._started)
            self._gap = min(LOG_EVERY, 2 * self._gap)
            self._next_line = now + self._gap

    def record(self) -> None:
        """Write this run's row into the table."""
        run, count = self._run, self._count
        run["updated"] = time.time()  # a clock that is set meanwhile was wrong at the start, too
        run["start"] = run["updated"] - (time.monotonic() - self._started)
        run["left_at_start"] = self._known + count.added
        run["left"] = run["left_at_start"] - count.done - count.failed
        run["work_left"], run["work_running"] = self._batches.seconds_left, count.running
        run["work_finished"], run["busy"], run["requests"] = count.finished, count.real, count.requests
        self._writer.log(self._slot, run)
        if self._bar is not None:
            self._bar.total = self._known + count.added
            self._bar.n = count.done + count.failed
            self._bar.set_postfix_str(f"{count.failed} failed, {self._eta()}")

    def end(self, efficiency: Efficiency) -> None:
        """Record that nothing more comes, and how well the ranks were used."""
        run, shares = self._run, efficiency.shares
        run["ended"], run["tail"], run["serving"] = True, efficiency.tail, efficiency.serving
        run["busy_share"], run["least_busy_share"] = np.mean(shares), min(shares)
        run["waited"] = sum(usage.waited for usage in efficiency.ranks)
        run["waited_cpu"] = sum(usage.waited_cpu for usage in efficiency.ranks)
        self.record()
        if self._bar is not None:
            self._bar.close()

    def _log(self, elapsed: float) -> None:
        done, of = self._count.done + self._count.failed, self._known + self._count.added
        known = " known so far" if self._more else ""
        say(f"{done} of {of} tasks{known}, {self._count.failed} failed, {elapsed:.0f} s, {self._eta()}")

    def _eta(self) -> str:
        eta = seconds_to_go(self._run[0])
        if eta is None:
            return "unknown time left"
        return f"about {math.ceil(eta)} s left{' for these, more may follow' if self._more else ''}"


def _bar(total: int) -> Any | None:
    if not sys.stderr.isatty():
        return None
    from tqdm import tqdm

    return tqdm(total=total, bar_format=BAR, file=sys.stderr)
