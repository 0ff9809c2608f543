"""`collapse TABLE -o PICTURE`: a ratio against one dimensionless number, and how well the rows collapse."""

import argparse
from typing import Any

from analysis import report
from analysis.chain import told_of
from analysis.collapse import NUMBERS, collapse
from analysis.commands import common
from analysis.output import write
from analysis.part import part_of
from analysis.quantity import ratio
from sweep.schema import PARAMETERS


def add(commands: Any) -> None:
    command = commands.add_parser("collapse", help="a ratio against a dimensionless number, and how well it collapses")
    common.add_picture(command, "the axis of the ratio")
    common.add_table(command)
    common.add_at(command)
    common.add_of(command, ratio)
    command.add_argument("--against", choices=list(NUMBERS), default="Pi_IV", help="default: %(default)s")
    command.add_argument("--colour", choices=PARAMETERS, default="N", help="of the dots, default: %(default)s")
    command.set_defaults(command=_collapse)


def _collapse(args: argparse.Namespace) -> list[str]:
    from analysis.draw_collapse import collapse_figure

    out, whole, look = common.begin(args, ratio)
    table, taken = common.at_values(args, whole)
    part = part_of(args.table, whole, table)
    found = collapse(table, args.against, args.of)
    told = " ".join(filter(None, (*part.values(), told_of(args.table, table))))
    figure = collapse_figure(found, args.colour, look, told)
    write(out, figure, found.rows[[*PARAMETERS, args.against, found.of]], look)
    used = f"{len(found.rows)} rows; left out: {found.reasons}"
    return [
        *taken,
        *report.rows_lines(table, used, part),
        f"collapse  {found}",
        *common.paths(args.table, out),
    ]
