"""`sweep submit SPEC`: the sweep as a job of a scheduler, or as an array of jobs."""

import argparse
from pathlib import Path
from typing import Any

from sweep.commands import common
from sweep.errors import InputError, gathered
from sweep.site import schedulers
from sweep.site.scheduler import Request, Scheduler
from sweep.store import writers

EPILOG = "what is not given follows from the plan: ten minutes of work or more per rank, at most 64 ranks and 12 hours"


def add(commands: Any) -> None:
    names, known = schedulers.names(), schedulers.ALL
    there = " or ".join(each.command for each in known)
    limits = " or ".join(each.name for each in known if each.has_limit)
    text = f"write the {names} script; submit it if {there} is there"
    submit = commands.add_parser("submit", help=text, epilog=EPILOG)
    submit.add_argument("spec", type=Path, help=common.SPEC)
    submit.add_argument("-o", "--output", type=Path, metavar="TABLE", help="default: the spec's name, .h5")
    submit.add_argument("--ranks", type=int, metavar="K", help="of the job, or of each of an array's jobs")
    submit.add_argument("--time", metavar="T", help=f"limit of one job, as {limits} writes it")
    submit.add_argument(
        "--array", type=int, metavar="N", help="N jobs that never talk, and one that merges their tables"
    )
    submit.add_argument("--writer", choices=writers.NAMES, default="auto", help="as of sweep run (default: auto)")
    submit.add_argument("--partition", metavar="P")
    submit.add_argument("--account", metavar="A")
    for each in known:
        flag, text = f"--{each.command}", f"{each.option_help}, as --{each.command}={each.option_example}"
        submit.add_argument(flag, action="append", default=[], metavar="OPTION", dest=each.name, help=text)
    submit.add_argument(
        "--dry-run", action="store_true", help="print what would be submitted; write and submit nothing"
    )
    if len(known) > 1:
        choices = (schedulers.AUTO, *(each.name for each in known))
        submit.add_argument("--scheduler", choices=choices, help="default: auto, the one whose command is there")
    submit.set_defaults(command=_submit, scheduler=schedulers.AUTO)


def _submit(args: argparse.Namespace) -> int:
    from sweep.site.submit import order, rehearse, submit  # pydantic, which the workers of a run do without

    scheduler = schedulers.chosen(args.scheduler)
    places, others = (args.partition, args.account), tuple(getattr(args, scheduler.name))
    asked = args.output, args.ranks, args.time, args.array
    strange = [each for each in schedulers.ALL if each is not scheduler and getattr(args, each.name)]
    ordered, _ = gathered(
        lambda: order(Request(args.spec, *asked, *places, others, args.writer), scheduler),
        lambda: _refuse_others(strange, scheduler),
    )
    print(rehearse(ordered) if args.dry_run else submit(ordered))
    return 0


def _refuse_others(strange: list[Scheduler], scheduler: Scheduler) -> None:
    """Options of schedulers that do not get the script would be lost."""
    if strange:
        way = f"which is not the one of this job, {scheduler.name}; --scheduler chooses it"
        raise InputError(*(f"--{each.command}: is an option of {each.name}, {way}" for each in strange))
