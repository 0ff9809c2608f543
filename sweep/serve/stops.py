"""Why a run hands out nothing more: a signal asked it to stop, its time is up, or too much has failed."""

import math
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import FrameType

from sweep.serve.master import Count

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
# A task may take so many times what is predicted: single ones scatter by a factor of 1.5 about the cost model
# (python -m tests.calibrate prints the scatter).
TIME_FACTOR = 1.6


@dataclass(frozen=True)
class Stops:
    """`deadline` in seconds since 1970."""

    asked: Callable[[], bool]
    deadline: float | None = None
    max_fails: int | None = None

    def also(self, asked: Callable[[], bool]) -> "Stops":
        """The same, which `asked` stops, too."""
        return replace(self, asked=lambda: self.asked() or asked())

    def fits(self, count: Count) -> float:
        """How many predicted seconds may still be started; nothing where the run is to stop."""
        if self.asked() or self.failed_too_often(count):
            return 0.0
        if self.deadline is None:
            return math.inf
        # The finished rows show how much slower than predicted this run is.
        return max(0.0, self.deadline - time.time()) / (TIME_FACTOR * max(1.0, count.ratio))

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


@contextmanager
def stop_on_signal() -> Iterator[Callable[[], bool]]:
    """Yields a function: whether one of STOP_SIGNALS has come since. A second signal kills, as if nothing caught it.

    Finished rows are in the table either way.
    """
    came: list[int] = []

    def handle(number: int, _frame: FrameType | None) -> None:
        came.append(number)
        for each in STOP_SIGNALS:
            signal.signal(each, signal.SIG_DFL)

    before = {number: signal.signal(number, handle) for number in STOP_SIGNALS}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def leave_it_to_the_master() -> None:
    """On a worker, ignore the signals: rank 0 gets them too, and hands out nothing more."""
    for number in STOP_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
