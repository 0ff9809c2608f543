"""Throws malformed specs and damaged tables at the command line: `python -m tests.fuzz [--cases N] [--seed S]`.

Every case must end with a documented exit status, one line per problem, no traceback and no hang, leave no file half
written, and stay within its memory; what is accepted must be right, row by row. A case is known by kind, seed and
number: `--kind` and `--first` repeat it. Exit status 1 where a rule was broken.
"""

import argparse
import functools
import sys
import time
from collections import Counter

from sweep import cli
from tests.fuzz import specs, tables
from tests.fuzz.children import AT_ONCE, CRASH, HANG, Case, run
from tests.fuzz.judge import ACCEPTED, FILES, MESSAGE, REFUSED, STATUS, TRACEBACK, WRONG

COLUMNS = (REFUSED, ACCEPTED, TRACEBACK, HANG, CRASH, STATUS, MESSAGE, FILES, WRONG)
_HEAD = f"{'kind':24}{'cases':>9}" + "".join(f"{name:>13}" for name in COLUMNS)


def main() -> int:
    """Print what was counted; the exit status."""
    parser = argparse.ArgumentParser(prog="tests.fuzz", description=__doc__)
    parser.add_argument("--cases", type=int, default=1000, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument(
        "--tables", type=float, default=0.04, metavar="F", help="their share of the cases: they cost more"
    )
    parser.add_argument("--seconds", type=float, default=float("inf"), metavar="T", help="stop then")
    parser.add_argument("--kind", help="only this one")
    parser.add_argument("--first", type=int, default=0, metavar="K", help="the number of the first case")
    args = parser.parse_args()
    end = time.monotonic() + args.seconds
    counts: dict[str, Counter[str]] = {}
    cli.parser = functools.cache(cli.parser)  # building it takes longer than reading a spec
    print(_HEAD, flush=True)
    with tables.sound() as truth:
        kinds = specs.KINDS | tables.kinds(truth)
        for place, (kind, case) in enumerate(kinds.items()):
            if args.kind in (None, kind):
                share = 1.0 if args.kind else _share(kind, args.tables)
                counts[kind] = _counted(kind, case, (args.seed, place), args.first, round(args.cases * share), end)
                print(_line(kind, counts[kind]), flush=True)
    print(_line("all", sum(counts.values(), Counter())))
    return int(any(count[name] for count in counts.values() for name in COLUMNS[2:]))


def _share(kind: str, of_tables: float) -> float:
    return of_tables / len(tables.DAMAGES) if kind in tables.DAMAGES else (1.0 - of_tables) / len(specs.KINDS)


def _counted(kind: str, case: Case, seed: tuple[int, int], first: int, cases: int, end: float) -> Counter[str]:
    count: Counter[str] = Counter()

    def tell(line: str) -> None:
        print(f"{kind}: {line}", flush=True)

    while count.total() < cases and time.monotonic() < end:
        start = first + count.total()
        run(case, seed, start, min(start + AT_ONCE, first + cases), count, tell)
    return count


def _line(kind: str, count: Counter[str]) -> str:
    return f"{kind:24}{count.total():9}" + "".join(f"{count[name]:13}" for name in COLUMNS)


if __name__ == "__main__":
    sys.exit(main())
