"""`page TABLE -o PAGE`: a table as one HTML file to explore in a browser, without a network."""

import argparse
from pathlib import Path
from typing import Any

from analysis import report
from analysis.at import pairs
from analysis.chain import made_of
from analysis.checks import require
from analysis.commands import common
from analysis.table import finished
from sweep.schema import PARAMETERS


def add(commands: Any) -> None:
    page = commands.add_parser("page", help="the table as one HTML file to explore in a browser")
    common.add_table(page)
    common.add_at(page)
    page.add_argument("-o", dest="output", metavar="PAGE", required=True, help=".html; needs no network, and no server")
    page.add_argument("--force", action="store_true", help="replace a file that this program did not write")
    page.set_defaults(command=_page)


def _page(args: argparse.Namespace) -> list[str]:
    path = Path(args.output)
    common.check_page(path, args.force)
    table = common.rows_of(Path(args.table), pairs(args.at))
    require(table, (*PARAMETERS, "ke_ratio", "chaotic"))
    from analysis.page import build, part_on_page  # Bokeh's scripts and jinja2, which the pictures do without

    part = part_on_page(args.table, table)
    table, taken = common.at_values(args, table) if args.at else (table, [])
    text = build(table, Path(args.table).name, part=" ".join(part.values()), made=made_of(args.table, table))
    page = common.write_page(path, text)
    return [
        *taken,
        f"rows      {len(finished(table))} done of {len(table)}",
        *report.part_lines(part),
        f"{page}, to be opened in a browser",
    ]
