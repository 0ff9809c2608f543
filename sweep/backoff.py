"""Waiting that does not spin: a blocked receive would burn a whole core."""

import time

SHORTEST, LONGEST = 1e-5, 1e-3


class Backoff:
    """Sleeps that double from 10 microseconds to 1 millisecond while nothing happens."""

    def __init__(self) -> None:
        self._pause = SHORTEST

    def wait(self) -> None:
        """Sleep, longer than the last time."""
        time.sleep(self._pause)
        self._pause = min(LONGEST, 2.0 * self._pause)

    def reset(self) -> None:
        """Something happened: be quick again."""
        self._pause = SHORTEST
