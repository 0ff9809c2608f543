"""Draws with replacement, from which an interval is told where no formula gives it."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np


def draws_of(places: Sequence[Any], n: int, rng: np.random.Generator | None = None) -> Iterator[list[Any]]:
    """`n` draws, each of as many of the places as there are. They are the same at every call, unless `rng` is given."""
    rng = np.random.default_rng(0) if rng is None else rng
    for _ in range(n):
        yield [places[k] for k in rng.integers(len(places), size=len(places))]
