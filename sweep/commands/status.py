"""`sweep status TABLE`: how far a sweep is."""

import argparse
from typing import Any

from sweep.commands import told


def add(commands: Any) -> None:
    """Put it into the grammar."""
    status = commands.add_parser("status", help="done, failed, left, rate, ETA; also while it is being written")
    told.add_table(status)
    told.add_json(status)
    status.set_defaults(command=_status)


def _status(args: argparse.Namespace) -> int:
    from sweep.tell import report, status_text  # pydantic, which the workers of a run do without

    told.tell(args, report.status(args.table), status_text.status_as_text)
    return 0
