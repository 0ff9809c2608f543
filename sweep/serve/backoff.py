"""Waiting that does not spin: a blocked receive would burn a whole core."""

import time

EAGER = 40  # looks before the first sleep, some 20 microseconds: what comes now comes in bursts
SHORTEST, LONGEST = 1e-5, 1e-3


class Backoff:
    """A moment of looking again at once, then sleeps that double from 10 microseconds to 1 millisecond."""

    def __init__(self) -> None:
        self._looks, self._pause = EAGER, SHORTEST

    def wait(self) -> None:
        """Sleep, longer than the last time."""
        if self._looks:
            self._looks -= 1
            return
        time.sleep(self._pause)
        self._pause = min(LONGEST, 2.0 * self._pause)

    def reset(self) -> None:
        """Something happened: be quick again."""
        self._looks, self._pause = EAGER, SHORTEST
