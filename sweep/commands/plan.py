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
    from sweep.plan.spec import read_spec  # pydantic, which the workers of a run do without
    from sweep.tell import plan_text, report

    spec, text = read_spec(args.spec)
    if not args.json:  # at once: the rest waits for the kernel where nobody has timed it here
        print(plan_text.counted_as_text(report.counted(spec)), flush=True)
    told.tell(args, report.plan(spec, text, args.spec.resolve().parent), plan_text.predicted_as_text)
    return 0
