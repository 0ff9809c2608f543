"""`sweep show TABLE`: where a table comes from."""

import argparse
from typing import Any

from sweep.commands import told


def add(commands: Any) -> None:
    """Put it into the grammar."""
    show = commands.add_parser("show", help="where a table comes from; also while it is being written")
    told.add_table(show)
    told.add_json(show)
    show.set_defaults(command=_show)


def _show(args: argparse.Namespace) -> int:
    from sweep.tell import report  # pydantic, which the workers of a run do without

    told.tell(args, report.show(args.table), report.as_text)
    return 0
