"""Intervals where no formula gives them, from draws with replacement; and that of a share, which has one."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.stats import binomtest

CONFIDENCE = 0.95
ENDS = ((1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2)


def draws_of(places: Sequence[Any], n: int, rng: np.random.Generator | None = None) -> Iterator[list[Any]]:
    """`n` draws, each of as many of the places as there are. They are the same at every call, unless `rng` is given."""
    rng = np.random.default_rng(0) if rng is None else rng
    for _ in range(n):
        yield [places[k] for k in rng.integers(len(places), size=len(places))]


def share_of(some: int, total: int) -> tuple[float, float, float]:
    """The share and its interval by Wilson; nan where there was no trial."""
    if not total:
        return np.nan, np.nan, np.nan
    interval = binomtest(some, total).proportion_ci(CONFIDENCE, "wilson")
    return some / total, float(interval.low), float(interval.high)
