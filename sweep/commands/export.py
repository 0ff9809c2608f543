"""`sweep export TABLE -o FILE`: the rows for other programs."""

import argparse
from pathlib import Path
from typing import Any

from sweep.commands import common
from sweep.errors import InputError

NOT_BESIDE_CRATE = {
    "--force": "a folder is never replaced; give another -o",
    "--all": "its table has every row, its rows.csv the done ones",
}


def add(commands: Any) -> None:
    export = commands.add_parser(
        "export",
        help="the done rows as .csv, .parquet or .nc, or with all that tells of them as an RO-Crate",
        parents=[common.TABLE],
    )
    export.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="FILE.csv, FILE.parquet or FILE.nc; with --crate a folder; one that exists is refused",
    )
    export.add_argument("--force", action="store_true", help="replace FILE where it exists, whatever it is")
    export.add_argument("--all", action="store_true", help="failed and pending rows too; a .nc has them anyway")
    export.add_argument("--crate", action="store_true", help="FILE is a folder: an RO-Crate of the table, to deposit")
    export.set_defaults(command=_export)


def _export(args: argparse.Namespace) -> int:
    from sweep.store.export import export

    if args.crate:
        given = {"--force": args.force, "--all": args.all}
        if lines := [f"{key}: must not stand beside --crate: {NOT_BESIDE_CRATE[key]}" for key in given if given[key]]:
            raise InputError(*lines)
        from sweep.store.crate import crate

        print(f"{crate(args.table, args.output)} rows in {args.output}")
        print(f"before it is deposited, write licence and authors into {args.output / 'ro-crate-metadata.json'}")
        return 0
    if args.all and args.output.suffix == ".nc":
        raise InputError(
            "--all: must not stand beside a .nc, which has a place for every row, failed and pending ones too"
        )
    print(f"{export(args.table, args.output, args.all, args.force)} rows in {args.output}")
    return 0
