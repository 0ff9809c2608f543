"""`sweep audit TABLE`: does a table keep its promise?"""

import argparse
from typing import Any

from sweep.commands import common
from sweep.errors import ALL_DONE, SOME_FAILED
from sweep.tell.promise import FRACTION, SAMPLE_MIN

EPILOG = "exit status: 0 the table keeps its promise; 1 it breaks it; 2 bad input"


def add(commands: Any) -> None:
    told = "recompute a sample much more tightly"
    command = commands.add_parser("audit", help=told, epilog=EPILOG, parents=[common.TABLE, common.JSON])
    text = f"of the done rows, {SAMPLE_MIN} at least (default: {FRACTION})"
    command.add_argument("--fraction", type=float, default=FRACTION, metavar="F", help=text)
    command.set_defaults(command=_audit)


def _audit(args: argparse.Namespace) -> int:
    from sweep.tell.audit import audit  # the kernel's compiled functions, which most commands do without
    from sweep.tell.text import of_audit

    answer = audit(args.table, args.fraction)
    common.print_answer(args, answer, of_audit)
    return ALL_DONE if answer["kept"] else SOME_FAILED
