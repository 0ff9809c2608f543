"""`sweep run SPEC -o TABLE`: compute a sweep, or what is left of it."""

import argparse
import os
import platform
import sys
import traceback
from pathlib import Path
from typing import Any

from sweep.commands import common
from sweep.errors import EXIT_STATUS, InputError
from sweep.plan.shard import parse_shard
from sweep.site import launch, schedulers
from sweep.store import writers

STORE_VARIABLE = "SWEEP_STORE"
TOLD = "run or resume a sweep; with N processes: mpirun -n N sweep run .."
UNTIL = "start nothing that does not fit before: 90m, 1:30:00, 17:30, an ISO time, none (default: as {} says)"

REUSE = (
    "take over the rows that this table has, computed to the same target or a tighter one, "
    "and certified unless this sweep is not; may be given more than once"
)
STORE = (
    "take the rows that sweeps have put into this folder, and put in what is computed, for any sweep that comes "
    f"(default: the environment variable {STORE_VARIABLE}, if it is set)"
)


def add(commands: Any) -> None:
    command = commands.add_parser("run", help=TOLD, epilog=EXIT_STATUS)
    command.add_argument("spec", type=Path, help=common.SPEC)
    command.add_argument(
        "-o", "--output", dest="table", type=Path, required=True, metavar="TABLE", help="created, or resumed"
    )
    command.add_argument("--writer", choices=writers.NAMES, default="auto", help="who writes rows (default: auto)")
    changed = command.add_mutually_exclusive_group()
    changed.add_argument("--keep-rows", action="store_true", help="resume although the kernel has changed since")
    changed.add_argument("--recompute", action="store_true", help="if the kernel has changed since, begin again")
    command.add_argument(
        "--shard", type=parse_shard, metavar="I/N", help="only the I-th of N shares of equal predicted cost, I from 1"
    )
    command.add_argument("--reuse", type=Path, action="append", default=[], metavar="OLD", help=REUSE)
    given = os.environ.get(STORE_VARIABLE) or None
    command.add_argument("--store", type=_folder, default=given, metavar="DIR", help=STORE)
    command.add_argument("--until", metavar="TIME", help=UNTIL.format(schedulers.names()))
    command.add_argument("--max-fails", type=_count, metavar="K", help="stop once more than K rows of this run failed")
    command.add_argument("--retry-failed", action="store_true", help="compute the rows that failed again")
    command.add_argument("--repair", action="store_true", help="save the intact rows of a damaged TABLE")
    command.add_argument("--page", type=Path, help="keep this .html as `analysis page` makes it of the table")
    command.set_defaults(command=_run, on_all_ranks=True, tells_wrong=True)


def _count(text: str) -> int:
    if not (text.isascii() and text.isdecimal()):
        raise argparse.ArgumentTypeError(f"must be a whole number, 0 or more, got {text!r}")
    return int(text)


def _folder(text: str) -> Path:
    if not text:  # of a variable that nobody has set, and no wish for a store here
        raise argparse.ArgumentTypeError("must be the path of a folder, got ''")
    return Path(text)


def _run(args: argparse.Namespace) -> int:
    from sweep.conduct import run  # the kernel's compiled functions, which most commands do without
    from sweep.prepare import Options
    from sweep.serve.messages import abort

    options = Options(**{name: value for name, value in vars(args).items() if name in Options.__match_args__})
    comm = launch.communicator()
    try:
        return run(comm, options)
    except InputError:
        raise
    except Exception:
        if comm is None:
            raise
        # The other ranks would wait for this one for ever.
        sys.stderr.write(f"sweep: rank {comm.rank} on {platform.node()}\n{traceback.format_exc()}")
        abort(comm, 1)
        raise
