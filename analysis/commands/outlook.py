"""`outlook -o PAGE`: what the paper leaves open, asked of tables of other laws, figures of merit and disorder."""

import argparse
import sys
from pathlib import Path
from typing import Any

from analysis.commands import common
from analysis.errors import InputError


def add(commands: Any) -> None:
    """Add this command to the command line."""
    page = commands.add_parser("outlook", help="what the paper leaves open: questions, rules and answers on one page")
    page.add_argument("-o", dest="output", metavar="PAGE", default="outlook.html", help="default: %(default)s")
    page.add_argument(
        "--tables", metavar="DIR", default="outlook", help="where `make outlook` put threshold.h5, .. (%(default)s)"
    )
    page.add_argument("--force", action="store_true", help="replace files that are not as this program left them")
    page.set_defaults(command=_outlook)


def _outlook(args: argparse.Namespace) -> list[str]:
    from analysis.outlook.page import NAME, build, missing, pictures
    from analysis.paper.recipe import Source  # the kernel, which the maps do without

    path, source = Path(args.output), Source(Path(args.tables))
    folder = path.with_suffix("")
    common.check_page(path, args.force, folder)
    if not source.tables.is_dir():
        raise InputError(f"there is no directory {source.tables} with tables; `make outlook` makes it")
    if lacks := missing(source):
        raise InputError(f"{source.tables} lacks {', '.join(lacks)}; `make outlook` makes them")
    common.check_pictures(pictures(folder), NAME, args.force)
    folder.mkdir(exist_ok=True)
    page = build(source, folder, progress=lambda text: print(text, file=sys.stderr))
    return [*page.lines, common.write_page(path, page.html), f"pictures  {folder}/*.png, *.csv"]
