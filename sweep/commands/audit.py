"""`sweep audit TABLE`: does a table keep its promise?"""

import argparse
from typing import Any

from sweep.commands import told
from sweep.run import SOME_FAILED

EPILOG = "exit status: 0 the table keeps its promise; 1 it breaks it; 2 bad input"


def add(commands: Any) -> None:
    """Put it into the grammar."""
    audit = commands.add_parser("audit", help="recompute a sample much more tightly", epilog=EPILOG)
    told.add_table(audit)
    audit.add_argument("--fraction", type=float, default=0.01, metavar="F", help="of the done rows (default: 0.01)")
    told.add_json(audit)
    audit.set_defaults(command=_audit)


def _audit(args: argparse.Namespace) -> int:
    from sweep.tell import audit, audit_text

    answer = audit.audit(args.table, args.fraction)
    told.tell(args, answer, audit_text.as_text)
    return 0 if answer["kept"] else SOME_FAILED
