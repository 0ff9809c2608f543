"""The store of `sweep run --store` beside LMDB: a million look-ups in ten million rows, random or those of a sweep.

python -m tests.stores [--rows 10000000] [--asked 1000000] [--in FOLDER]

Every row is unpacked, its checksum and its inputs are compared. Seconds: of this process's core, and of the wall; of
look-ups the fastest of five, and the slowest.
LMDB is tried where it is installed (pip install lmdb), with the same keys and rows; its rows are only fetched.
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from sweep.plan.tasks import Tasks
from sweep.schema import DONE, ROW, blank_of, seal
from sweep.store.blocks import keys_of
from sweep.store.shelf import FILE, Shelf

AXES = {
    "zeta_T": np.geomspace(1e-5, 1, 100),
    "M_over_M0": np.geomspace(0.1, 10, 20),
    "V_over_V0": np.geomspace(0.1, 10, 50),
}
AT_ONCE = 200_000  # rows of one writing
TIMES = 5  # that each look-up is timed: others may want the core and its caches


def parts(tasks: Tasks, count: int) -> Iterator[np.ndarray]:
    """Sealed rows of the first tasks."""
    for first in range(0, count, AT_ONCE):
        ids = np.arange(first, min(first + AT_ONCE, count))
        rows = blank_of(tasks.columns(ids))
        rows["status"], rows["ke_ratio"] = DONE, ids
        seal(rows)
        yield rows


def timed(name: str, answer: Callable[[], int], times: int = 1) -> None:
    every = list[tuple[float, float]]()
    for _ in range(times):
        wall, core = time.perf_counter(), time.thread_time()
        found = answer()
        every.append((time.thread_time() - core, time.perf_counter() - wall))
    (best, wall), worst = min(every), max(every)[0]
    told = f"{best:6.2f} s of a core" + (f" ({best:.2f} to {worst:.2f} of {times})" if times > 1 else "")
    print(f"{name:32} {found} found in {told}, {wall:6.2f} s", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=int, default=10_000_000)
    parser.add_argument("--asked", type=int, default=1_000_000)
    parser.add_argument("--in", type=Path, dest="place", help="where the stores are made, and deleted")
    args = parser.parse_args()
    tasks = Tasks({"N": np.arange(2, 2 + -(-args.rows // 100_000)), **AXES})
    rng, begin = np.random.default_rng(1), (args.rows - args.asked) // 2
    asked = {"random": rng.choice(args.rows, args.asked, replace=False), "of one sweep": begin + np.arange(args.asked)}
    with tempfile.TemporaryDirectory(dir=args.place) as folder:
        shelf = Shelf(Path(folder))
        kind, origin = shelf.kind("rows"), shelf.origin("here")
        timed(
            "SQLite, put", lambda: sum(shelf.put(kind, origin, rows) or len(rows) for rows in parts(tasks, args.rows))
        )
        print(f"{(Path(folder) / FILE).stat().st_size / args.rows:.0f} bytes a row")
        for name, ids in asked.items():
            timed(f"SQLite, {name}", lambda ids=ids: len(shelf.find(kind, tasks.columns(ids), ROW).where), TIMES)
        shelf.close()
        try:
            import lmdb
        except ImportError:
            return
        with lmdb.open(f"{folder}/l.mdb", map_size=1 << 40, subdir=False) as base:
            timed("LMDB, put", lambda: sum(_put(base, kind, rows) for rows in parts(tasks, args.rows)))
            for name, ids in asked.items():
                timed(f"LMDB, {name}, fetched only", lambda ids=ids: _found(base, _keys(kind, tasks.columns(ids))))


def _keys(kind: int, columns: dict[str, np.ndarray]) -> list[bytes]:
    return [key.tobytes() for key in np.sort(keys_of(kind, columns)).astype(">i8")]


def _put(base: object, kind: int, rows: np.ndarray) -> int:
    keys = [key.tobytes() for key in keys_of(kind, {name: rows[name] for name in ROW.names[:4]}).astype(">i8")]
    with base.begin(write=True) as transaction:
        transaction.cursor().putmulti([(key, row.tobytes()) for key, row in zip(keys, rows, strict=True)])
    return len(rows)


def _found(base: object, keys: list[bytes]) -> int:
    with base.begin() as transaction:
        return sum(transaction.get(key) is not None for key in keys)


if __name__ == "__main__":
    main()
