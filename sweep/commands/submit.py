"""`sweep submit SPEC`: the sweep as a SLURM job, or as an array of them."""

import argparse
from pathlib import Path
from typing import Any

EPILOG = "what is not given follows from the plan: ten minutes of work or more per rank, at most 64 ranks and 12 hours"


def add(commands: Any) -> None:
    """Put it into the grammar."""
    submit = commands.add_parser("submit", help="write the SLURM script; submit it if sbatch is there", epilog=EPILOG)
    submit.add_argument("spec", type=Path)
    submit.add_argument("-o", "--output", type=Path, metavar="TABLE", help="default: the spec's name, .h5")
    submit.add_argument("--ranks", type=int, metavar="K", help="of the job, or of each of an array's jobs")
    submit.add_argument("--time", metavar="T", help="limit of one job, as SLURM writes it")
    submit.add_argument(
        "--array", type=int, metavar="N", help="N jobs that never talk, and one that merges their tables"
    )
    submit.add_argument("--partition", metavar="P")
    submit.add_argument("--account", metavar="A")
    submit.add_argument(
        "--sbatch", action="append", default=[], metavar="OPTION", help="any other, as --sbatch=--mem=4G"
    )
    submit.add_argument(
        "--dry-run", action="store_true", help="print what would be submitted; write and submit nothing"
    )
    submit.set_defaults(command=_submit)


def _submit(args: argparse.Namespace) -> int:
    from sweep.site.submit import Wish, order, rehearse, submit  # pydantic, which the workers of a run do without

    places = args.partition, args.account
    ordered = order(Wish(args.spec, args.output, args.ranks, args.time, args.array, *places, tuple(args.sbatch)))
    print(rehearse(ordered) if args.dry_run else submit(ordered))
    return 0
