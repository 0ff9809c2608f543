"""How long work that is under way may take before it counts as lost: every wait has an end."""

import math
import time
from collections.abc import Callable

# Seconds in which a disk or a network that is held up may go on, and how many times what is predicted the tasks under
# way may take: chaotic ones take five times the mean of their like (plan.cost.MORE_RANGE), twice over.
GRACE_MIN, GRACE_FACTOR = 60.0, 10.0


def grace(predicted: float) -> float:
    """Seconds after which work that should take so many has ended, or never will."""
    return GRACE_MIN + GRACE_FACTOR * predicted


class Grace:
    """What is under way when a signal comes may end, but not take for ever: a rank may be lost or stuck."""

    def __init__(self, asked: Callable[[], bool]) -> None:
        self._asked, self._since = asked, math.inf

    def is_over(self, longest: float) -> bool:
        """Whether the tasks under way, of which the longest batch is to take so many seconds, should have ended."""
        if not self._asked():
            return False
        self._since = min(self._since, time.monotonic())
        return time.monotonic() - self._since > grace(longest)
