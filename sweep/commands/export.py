"""`sweep export TABLE -o FILE`: the rows for other programs."""

import argparse
from pathlib import Path
from typing import Any

from sweep.commands import common


def add(commands: Any) -> None:
    export = commands.add_parser("export", help="the done rows as .csv or .parquet")
    common.add_table(export)
    export.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="FILE.csv or FILE.parquet; one that exists is refused",
    )
    export.add_argument("--force", action="store_true", help="replace FILE where it exists, whatever it is")
    export.add_argument("--all", action="store_true", help="failed and pending rows too")
    export.set_defaults(command=_export)


def _export(args: argparse.Namespace) -> int:
    from sweep.store.export import export

    print(f"{export(args.table, args.output, args.all, args.force)} rows in {args.output}")
    return 0
