"""What every rank did with its time, for the report at the end of a run."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")


@dataclass
class Usage:
    """Seconds of one rank."""

    busy: float = 0.0  # computing and writing
    waited: float = 0.0  # for work
    waited_cpu: float = 0.0  # of a core, spent on waiting

    def waiting(self, wait: Callable[[], T]) -> T:
        """Count what `wait` takes."""
        start, cpu = time.perf_counter(), time.thread_time()
        answer = wait()
        self.waited += time.perf_counter() - start
        self.waited_cpu += time.thread_time() - cpu
        return answer


@dataclass(frozen=True)
class Efficiency:
    """Of a whole run."""

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
        """Seconds of all ranks together."""
        return sum(usage.busy for usage in self.ranks)

    def __str__(self) -> str:
        shares, waited = self.shares, sum(usage.waited for usage in self.ranks)
        told = " ".join(f"{share:.0%}" for share in shares) if len(shares) <= 8 else f"least {min(shares):.0%}"
        cpu = sum(usage.waited_cpu for usage in self.ranks) / waited if waited > 0 else 0.0
        return (
            f"ranks busy {sum(shares) / len(shares):.1%} ({told}), waited {waited:.2f} s at {cpu:.1%} of a core; "
            f"tail {self.tail:.2f} s; serving took {self.serving:.2f} s; "
            f"computing took {self.busy:.1f} s, predicted {self.predicted:.1f} s"
        )
