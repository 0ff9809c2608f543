"""Random histories of tables: `python -m tests.histories [--seed S] [--steps N] [--histories K]`.

Each history draws a small spec and then a number of steps: runs alone or on two or three ranks, with either writer,
killed, stopped or short of time; shards; merging; rows taken from tables and from a store; guests; damage and repair;
exports; other specs and other kernels. After every step each table must hold what it held, only rows that a run in
peace on one rank has, and its status must be true. In the end every table is completed: it has the bits of such a run,
and nothing is left behind.

History number k has the seed S + k. A violation is told with the history that led to it; exit status 1.
"""

import argparse
import contextlib
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests import shared_memory
from tests.histories.commands import Hung, load
from tests.histories.specs import KINDS, drawn
from tests.histories.steps import Steps
from tests.histories.world import Violation, World


def history(seed: int, steps: int, ranks: int, only: str, loud: bool) -> str:
    """What is wrong with it; nothing, where nothing is."""
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        world = World(Path(name), rng)
        asked = drawn(rng, only)
        why = ""
        try:
            begun = time.monotonic()
            world.truth(asked.text)
            world.life = time.monotonic() - begun
            taken = Steps(world, asked, ranks)
            for _ in range(steps):
                taken.one()
            taken.end()
        except (Violation, Hung) as error:
            why = f"seed {seed}: {error}"
        except Exception as error:  # of a command, or a look at a table
            import traceback

            why = f"seed {seed}: {error!r}\n{traceback.format_exc()}"
        if why or loud:
            print(f"seed {seed}, {asked.kind}\n{asked.text}", *world.log, sep="\n  ", flush=True)
    return why


def main() -> int:
    """Print what was found; the exit status."""
    parser = argparse.ArgumentParser(
        prog="tests.histories", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument("--steps", type=int, default=8, metavar="N", help="of each history")
    parser.add_argument("--histories", type=int, default=1, metavar="K")
    parser.add_argument("--ranks", type=int, default=3, metavar="R", help="of a run, at most")
    parser.add_argument("--only", default="", choices=("", *KINDS), help="specs of this kind")
    parser.add_argument("--seconds", type=float, default=float("inf"), metavar="T", help="stop then")
    parser.add_argument("--loud", action="store_true", help="print every history")
    args = parser.parse_args()
    load()
    end, wrong, number = time.monotonic() + args.seconds, 0, 0
    with shared_memory.cleared(), contextlib.suppress(KeyboardInterrupt):
        while number < args.histories and time.monotonic() < end:
            if why := history(args.seed + number, args.steps, args.ranks, args.only, args.loud):
                wrong += 1
                print(why, flush=True)
            number += 1
    print(f"{number} histories of {args.steps} steps, {wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
