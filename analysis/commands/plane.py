"""`map TABLE -o PICTURE`: ke_ratio over two parameters."""

import argparse
from collections.abc import Sequence
from typing import Any

from analysis import draw, report
from analysis.commands import common
from analysis.errors import InputError
from analysis.output import write
from analysis.plane import plane
from sweep.schema import PARAMETERS


def add(commands: Any) -> None:
    """Put it into the grammar."""
    command = commands.add_parser("map", help="ke_ratio over two parameters")
    common.add_picture(command)
    common.add_table(command)
    command.add_argument("--over", default="N,zeta_T", metavar="ACROSS,UP", help=f"two of {', '.join(PARAMETERS)}")
    command.add_argument(
        "--at", action="extend", nargs="+", default=[], metavar="NAME=VALUE", help="fix a parameter at a value"
    )
    command.set_defaults(command=_map)


def _map(args: argparse.Namespace) -> list[str]:
    over = tuple(args.over.split(","))
    at = _values(args.at)
    out, table = common.begin(args)
    cells = plane(table, over, at)
    if not cells["ke_ratio"].notna().any():
        raise InputError("no finished row of this map has a ke_ratio")
    write(out, draw.plane_map(cells, over), cells)
    return [*report.plane_used(table, cells, over), *report.lowest(cells), *common.paths(args.table, out)]


def _values(pairs: Sequence[str]) -> dict[str, float]:
    values: dict[str, float] = {}
    for pair in pairs:
        name, _, text = pair.partition("=")
        try:
            number = float(text)
        except ValueError:
            raise InputError(f"--at {pair}: write NAME=VALUE with a number, for example N=200") from None
        if name in values:
            raise InputError(f"--at gives {name} twice")
        values[name] = number
    return values
