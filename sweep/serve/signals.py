"""Stopping cleanly: the first signal asks, the second one kills; finished rows are in the table either way."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

ASK = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)


@contextmanager
def stop_on_signal() -> Iterator[Callable[[], bool]]:
    """Yields a function that says whether SIGINT, SIGTERM or SIGUSR1 has come since."""
    came: list[int] = []

    def handle(number: int, _frame: FrameType | None) -> None:
        came.append(number)
        for each in ASK:
            signal.signal(each, signal.SIG_DFL)

    before = {number: signal.signal(number, handle) for number in ASK}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def leave_it_to_the_master() -> None:
    """On a worker: finish the batch; rank 0 gets the same signal and stops handing out."""
    for number in ASK:
        signal.signal(number, signal.SIG_IGN)
