"""Stopping cleanly: the first signal asks, the second one acts at once."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

ASK = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)


@contextmanager
def stop_on_signal(stop: Callable[[], None]) -> Iterator[None]:
    """Call `stop` on the first SIGINT, SIGTERM or SIGUSR1."""

    def handle(number: int, _frame: FrameType | None) -> None:
        stop()
        signal.signal(number, before[signal.Signals(number)])

    before = {number: signal.signal(number, handle) for number in ASK}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def leave_it_to_the_master() -> None:
    """On a worker: finish the batch; rank 0 gets the same signal and stops handing out."""
    for number in ASK:
        signal.signal(number, signal.SIG_IGN)
