"""`sweep merge A B ... -o TABLE`: one table from several."""

import argparse
import os
from pathlib import Path
from typing import Any

from sweep.commands import common
from sweep.errors import status_of
from sweep.site import schedulers

EPILOG = "exit status: 0 all rows done; 1 some rows failed; 2 bad input; 75 some rows are in none of the tables"


def add(commands: Any) -> None:
    told = "join shards, or any sweeps of one chain, accuracy and set of columns"
    merge = commands.add_parser("merge", help=told, epilog=EPILOG, parents=[common.JSON])
    merge.add_argument("tables", type=Path, nargs="+", metavar="TABLE", help="written by `sweep run`")
    merge.add_argument(
        "-o", "--output", type=Path, required=True, metavar="TABLE", help="one that exists is joined too, and replaced"
    )
    merge.add_argument("--keep-rows", action="store_true", help="join although different kernels have computed")
    merge.set_defaults(command=_merge)


def _merge(args: argparse.Namespace) -> int:
    from sweep.store.merge import merge  # pydantic, which the workers of a run do without
    from sweep.tell.text import of_answer

    answer = merge(args.tables, args.output, args.keep_rows, schedulers.job(os.environ))
    common.print_answer(args, answer, of_answer)
    return status_of(answer["failed"], answer["left"])
