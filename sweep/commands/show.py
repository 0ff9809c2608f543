"""`sweep show TABLE`: where a table comes from."""

import argparse
from typing import Any

from sweep.commands import common


def add(commands: Any) -> None:
    show = commands.add_parser(
        "show", help="where a table comes from; also while it is being written", parents=[common.TABLE, common.JSON]
    )
    show.set_defaults(command=_show)


def _show(args: argparse.Namespace) -> int:
    from sweep.tell import report, text  # pydantic, which the workers of a run do without

    common.print_answer(args, report.show(args.table), text.of_show)
    return 0
