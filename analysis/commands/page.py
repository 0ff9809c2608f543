"""`page TABLE -o PAGE`: a table as one HTML file to explore in a browser, without a network."""

import argparse
from pathlib import Path
from typing import Any

from analysis.at import pairs
from analysis.commands import common
from analysis.errors import InputError
from analysis.output import replacing
from analysis.table import finished
from sweep.files import page_problem


def add(commands: Any) -> None:
    """Add this command to the command line."""
    page = commands.add_parser("page", help="the table as one HTML file to explore in a browser")
    common.add_table(page)
    common.add_at(page)
    page.add_argument("-o", dest="output", metavar="PAGE", required=True, help=".html; needs no network, and no server")
    page.add_argument("--force", action="store_true", help="replace a file that this program did not write")
    page.set_defaults(command=_page)


def _page(args: argparse.Namespace) -> list[str]:
    path = Path(args.output)
    if problem := page_problem(path, args.force):
        raise InputError(problem)
    table = common.rows_of(Path(args.table), pairs(args.at))
    table, taken = common.at_values(args, table) if args.at else (table, [])
    from analysis.page import build  # Bokeh's scripts and jinja2, which the pictures do without

    text = build(table, Path(args.table).name)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return [
        *taken,
        f"rows      {len(finished(table))} done of {len(table)}",
        f"page      {path} ({path.stat().st_size / 1e6:.1f} MB), to be opened in a browser",
    ]
