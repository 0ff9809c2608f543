"""A shard: one job's share of a sweep. Jobs of different shards exchange nothing; `sweep merge` joins their tables."""

import argparse
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError
from sweep.plan.parts import PART, Predict
from sweep.plan.tasks import Chosen, TaskList

SHARDS_MAX = 100_000  # beyond, it is a typing error
# Steps of predicted work from any to its double; tasks of one step count as equal. Coarser steps deal less evenly;
# at the border of two steps last bits decide all the same (for one of 1e8 tasks, in one sweep of some 10 000).
STEPS = 64


@dataclass(frozen=True)
class Shard:
    """Number `index` of `count`, counted from 1 as job arrays are."""

    index: int
    count: int

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"


def parse_shard(text: str) -> Shard:
    """The shard that `I/N` names; for argparse, whose error it raises where the text is none."""
    numbers = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
    shard = Shard(*map(int, numbers.groups())) if numbers else None
    if shard is None or not 1 <= shard.index <= shard.count <= SHARDS_MAX:
        raise argparse.ArgumentTypeError(
            f"must be I/N, two whole numbers with 1 <= I <= N <= {SHARDS_MAX}, got {text!r}"
        )
    return shard


def share(tasks: TaskList, predict: Predict, shard: Shard) -> Chosen:
    """The tasks of one shard. `predict`: the cost model alone, so that every machine deals alike.

    A large sweep is dealt out part by part, as all at once would take gigabytes.
    """
    if shard.count > len(tasks):
        raise InputError(f"--shard: {shard} leaves shards without a task; the sweep has {len(tasks)}")
    starts = range(0, len(tasks), PART)
    parts = (np.arange(first, min(first + PART, len(tasks))) for first in starts)
    return Chosen(tasks, np.concatenate([ids[dealt(predict(ids), shard.count) == shard.index - 1] for ids in parts]))


def dealt(work: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """For each task its shard, from 0, so that all have nearly the same work.

    The tasks are dealt out from the longest to the shortest, forwards and backwards in turn, so that every shard gets
    its share of the longest too. Those of nearly equal work go by number: the last bits of exp and log differ between
    kinds of processor, and all must deal alike.
    """
    places, steps = np.arange(len(work)), np.rint(STEPS * np.log2(work))
    order, place = np.lexsort((places, -steps)), places % (2 * count)
    shards = np.empty(len(work), np.int64)
    shards[order] = np.minimum(place, 2 * count - 1 - place)
    return shards
