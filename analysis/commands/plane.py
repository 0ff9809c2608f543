"""`map TABLE -o PICTURE`: ke_ratio over two parameters."""

import argparse
from typing import Any

from analysis import choose, draw, notes, report
from analysis.commands import common
from analysis.errors import InputError
from analysis.output import write
from analysis.plane import check_names, plane
from sweep.schema import PARAMETERS


def add(commands: Any) -> None:
    """Put it into the grammar."""
    command = commands.add_parser("map", help="ke_ratio over two parameters")
    common.add_picture(command, "the colours of ke_ratio")
    common.add_table(command)
    command.add_argument("--over", default="N,zeta_T", metavar="ACROSS,UP", help=f"two of {', '.join(PARAMETERS)}")
    command.add_argument(
        "--at", action="extend", nargs="+", default=[], metavar="NAME=VALUE", help="fix a parameter at a value"
    )
    command.set_defaults(command=_map, name="map")


def _map(args: argparse.Namespace) -> list[str]:
    over, at = tuple(args.over.split(",")), choose.pairs(args.at)
    check_names((*over, *at))
    out, table, look = common.begin(args)
    at, told = choose.taken(table, at)
    cells = plane(table, over, at)
    if not cells["ke_ratio"].notna().any():
        raise InputError("no finished row of this map has a ke_ratio")
    behind = notes.of_plane(table, cells, over, at)
    write(out, draw.plane_map(cells, over, behind, look), cells, look)
    return [
        *told,
        *report.plane_used(table, cells, over, behind),
        *report.lowest(cells),
        *common.paths(args.table, out),
    ]
