"""Rows of neighbouring keys in one block, which a store keeps as one record. Knows no file.

A look-up of many rows then fetches few records, and numpy does the rest. A block has an index, with a checksum; every
row has its own. So damage costs the row that it strikes, or the block whose index it strikes.
"""

import zlib
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sweep.plan.tasks import Columns, inputs
from sweep.schema import whole

INDEX = np.dtype([("key", "<i8"), ("origin", "<i4")])  # of each row
# Bytes of rows at most: with half of it random look-ups took 1.4 times as long, with twice as much they were no faster,
# and rows that come one by one took twice as long to put in.
BLOCK = 32768
# Bits of a key that tell tasks of one chain apart; those above bring such rows together, so that a batch of them
# changes few blocks. Of ten million rows a thousand to each chain, two get one key in one store out of a thousand.
CHAIN, TASK_BITS = ("N", "zeta_T"), 43
Record = tuple[int, int, bytes, bytes]  # the first key that may be in it, checksum of the INDEX, the INDEX, the rows


class Entries(NamedTuple):
    """Rows by ascending keys, none of which occurs twice."""

    keys: NDArray[np.int64]
    origins: NDArray[np.int32]  # where each row was computed
    rows: NDArray[np.void]

    def at(self, which: NDArray[np.int64] | slice) -> "Entries":
        """Some of them."""
        return Entries(self.keys[which], self.origins[which], whole(self.rows)[which].view(self.rows.dtype))


def keys_of(kind: int, columns: Columns) -> NDArray[np.int64]:
    """A number from 0 to 2**63 for every task; two tasks have the same one hardly ever, which readers must check."""
    task = chain = _stirred(np.zeros(len(columns["N"]), np.uint64), np.uint64(kind))
    for name in inputs(columns):
        values = np.asarray(columns[name])
        bits = values.astype(np.float64).view(np.uint64) if values.dtype.kind == "f" else values.astype(np.uint64)
        task = _stirred(task, bits)
        chain = _stirred(chain, bits) if name in CHAIN else chain
    low = task & np.uint64(2**TASK_BITS - 1)
    return (((chain >> np.uint64(TASK_BITS + 1)) << np.uint64(TASK_BITS)) | low).astype(np.int64)


def _stirred(known: NDArray[np.uint64], bits: NDArray[np.uint64] | np.uint64) -> NDArray[np.uint64]:
    """The finaliser of splitmix64, each of whose bits depends on all of its input's."""
    mixed = (known ^ bits) + np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return mixed ^ (mixed >> np.uint64(31))


def by_key(kind: int, origin: int, rows: NDArray[np.void], names: Sequence[str]) -> Entries:
    """Rows that are to be kept, of which several may be of one task; `names`: their columns that say which."""
    keys = keys_of(kind, {name: rows[name] for name in names})
    return _unique(Entries(keys, np.full(len(rows), origin, INDEX["origin"]), rows))


def merged(old: Entries, new: Entries) -> Entries:
    """Both; where they have one key, the new one."""
    rows = np.concatenate([whole(old.rows), whole(new.rows)]).view(new.rows.dtype)
    return _unique(Entries(np.concatenate([old.keys, new.keys]), np.concatenate([old.origins, new.origins]), rows))


def _unique(entries: Entries) -> Entries:
    """In order; of those with one key the last."""
    order = np.argsort(entries.keys, kind="stable")
    keys = entries.keys[order]
    return entries.at(order[np.append(keys[1:] != keys[:-1], np.ones(len(keys[:1]), np.bool_))])


def entries_of(records: Sequence[Record], layout: np.dtype[Any]) -> Entries:
    """What these hold, which must ascend. A damaged one holds nothing."""
    sound = [record for record in records if _is_sound(record, layout.itemsize)]
    index = np.frombuffer(b"".join([index for _, _, index, _ in sound]), INDEX)
    rows = np.frombuffer(b"".join([rows for *_, rows in sound]), layout)
    return Entries(index["key"].copy(), index["origin"].copy(), rows)


def _is_sound(record: Record, size: int) -> bool:
    _, checksum, index, rows = record
    try:
        return len(rows) * INDEX.itemsize == len(index) * size and zlib.crc32(index) == checksum
    except TypeError:  # of damage to SQLite's own word for what kind of value it is
        return False


def records_of(entries: Entries, firsts: Sequence[int]) -> Iterator[Record]:
    """Entries as records, of which those of more than BLOCK are split; `firsts`: where the blocks began so far."""
    most = max(1, BLOCK // entries.rows.itemsize)
    index = np.empty(len(entries.keys), INDEX)
    index["key"], index["origin"] = entries.keys, entries.origins
    bounds = [0, *np.searchsorted(entries.keys, firsts[1:]).tolist(), len(entries.keys)]
    for first, (begin, end) in zip(firsts, pairwise(bounds), strict=True):
        count = max(1, -(-(end - begin) // most))
        cuts = [begin + (end - begin) * k // count for k in range(count + 1)]
        for low, high in pairwise(cuts):
            part = index[low:high].tobytes()
            key = first if low == begin else int(entries.keys[low])
            yield key, zlib.crc32(part), part, entries.rows[low:high].tobytes()
