"""Many tasks on several cores of one machine: compiled code runs without Python's lock, so threads do."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

AT_ONCE = 16  # tasks that a thread takes: one may cost a thousand times another, and threads shall end together


def in_threads(count: int, workers: int, compute: Callable[[slice], NDArray[Any]]) -> NDArray[Any]:
    """What `compute` gives for 0 .. count, in order, part by part on so many threads."""
    parts = [slice(first, first + AT_ONCE) for first in range(0, count, AT_ONCE)]
    if workers == 1 or len(parts) < 2:
        return compute(slice(None))
    pool = ThreadPoolExecutor(workers, thread_name_prefix="tasks")
    try:
        return np.concatenate(list(pool.map(compute, parts)))
    finally:
        pool.shutdown(cancel_futures=True)  # after Ctrl-C only what was begun is awaited
