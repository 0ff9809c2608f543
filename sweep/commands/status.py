"""`sweep status TABLE`: how far a sweep is."""

import argparse
from typing import Any

from sweep.commands import common


def add(commands: Any) -> None:
    status = commands.add_parser(
        "status",
        help="done, failed, left, rate, ETA; also while it is being written",
        parents=[common.TABLE, common.JSON],
    )
    status.set_defaults(command=_status)


def _status(args: argparse.Namespace) -> int:
    from sweep.tell import report, text  # pydantic, which the workers of a run do without

    common.print_answer(args, report.status(args.table), text.of_status)
    return 0
