"""Why a run hands out nothing more: it was asked to stop, its time is up, or too much has failed."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from sweep.serve.master import Count

# A task may take this much longer than predicted: single ones scatter by a factor of 1.5 about the cost model.
SAFETY = 1.6


@dataclass(frozen=True)
class Stops:
    """`deadline` in seconds since 1970."""

    asked: Callable[[], bool]
    deadline: float | None = None
    max_fails: int | None = None

    def fits(self, count: Count) -> float:
        """How many predicted seconds may still be started; nothing where the run is to stop."""
        if self.asked() or self.failed_too_often(count):
            return 0.0
        if self.deadline is None:
            return math.inf
        # What was finished tells how much slower than predicted this run is.
        return max(0.0, self.deadline - time.time()) / (SAFETY * max(1.0, count.ratio))

    def failed_too_often(self, count: Count) -> bool:
        """More rows of this run failed than the user accepts."""
        return self.max_fails is not None and count.failed > self.max_fails

    def reason(self, count: Count) -> str:
        """For the log, of a run that has left tasks undone."""
        if self.failed_too_often(count):
            return f"{count.failed} rows failed, more than --max-fails {self.max_fails}"
        if self.asked():
            return "asked to by a signal"
        return "what is left does not fit before the end of the allotted time"
