"""`sweep plan SPEC`: what a sweep would cost."""

import argparse
from pathlib import Path
from typing import Any

from sweep.commands import told


def add(commands: Any) -> None:
    """Put it into the grammar."""
    plan = commands.add_parser("plan", help="tasks, predicted cost, table size; runs nothing")
    plan.add_argument("spec", type=Path)
    told.add_json(plan)
    plan.set_defaults(command=_plan)


def _plan(args: argparse.Namespace) -> int:
    from sweep.tell import plan_text, report  # pydantic, which the workers of a run do without

    if not args.json:  # at once: the rest waits for the kernel, which tells how fast this machine is
        print(plan_text.counted_as_text(report.counted(args.spec)), flush=True)
    told.tell(args, report.plan(args.spec), plan_text.predicted_as_text)
    return 0
