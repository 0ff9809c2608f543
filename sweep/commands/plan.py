"""`sweep plan SPEC`: what a sweep would cost."""

import argparse
from pathlib import Path
from typing import Any

from sweep.commands import common


def add(commands: Any) -> None:
    plan = commands.add_parser("plan", help="tasks, predicted cost, table size; runs no task", parents=[common.JSON])
    plan.add_argument("spec", type=Path, help=common.SPEC)
    plan.set_defaults(command=_plan)


def _plan(args: argparse.Namespace) -> int:
    from sweep.plan.spec import read_spec  # pydantic, which the workers of a run do without
    from sweep.tell import report, text

    spec, source = read_spec(args.spec)
    if not args.json:  # at once: the rest waits for the kernel where nobody has timed it here
        print(text.of_counts(report.counted(spec)), flush=True)
    common.print_answer(args, report.plan(spec, source, args.spec.resolve().parent), text.of_prediction)
    return 0
