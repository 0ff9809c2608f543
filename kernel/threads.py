"""Many tasks on several cores of one machine: compiled code runs without Python's lock, so threads do."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Compiled code does not look for Ctrl-C. So a thread computes so long between two looks, or one task where that takes
# longer. Parts of a hundredth of it would make the cheapest tasks a tenth dearer.
SECONDS_AT_ONCE = 0.1


def in_threads(count: int, workers: int, compute: Callable[[slice], NDArray[Any]]) -> NDArray[Any]:
    """What `compute` gives for 0 .. count, in order, part by part on so many threads."""
    if count == 0:
        return compute(slice(0))
    done, taken, lock = {}, 0, threading.Lock()

    def next_part(size: int) -> slice:
        nonlocal taken
        with lock:
            first, taken = taken, min(count, taken + size)
        return slice(first, taken)

    def work(_: int = 0) -> None:
        size = 1
        while (part := next_part(size)).start < count:
            began = time.monotonic()
            done[part.start] = compute(part)
            size = 2 * size if time.monotonic() - began < SECONDS_AT_ONCE else max(1, size // 2)

    if workers == 1 or count == 1:
        work()
    else:
        pool = ThreadPoolExecutor(workers, thread_name_prefix="tasks")
        try:
            list(pool.map(work, range(min(workers, count))))
        finally:
            next_part(count)  # after Ctrl-C only what was begun is awaited
            pool.shutdown()
    return np.concatenate([done[first] for first in sorted(done)])
