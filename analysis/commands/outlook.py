"""`outlook -o PAGE`: what the paper leaves open, asked of tables of other laws, figures of merit and disorder."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from analysis.commands import common
from analysis.errors import InputError


def add(commands: Any) -> None:
    page = commands.add_parser("outlook", help="what the paper leaves open: questions, rules and answers on one page")
    common.add_page_of_tables(page, "outlook", "threshold.h5")
    page.set_defaults(command=_outlook)


def _outlook(args: argparse.Namespace) -> list[str]:
    from analysis.outlook.page import NAME, build, missing, pictures
    from analysis.paper.recipe import Source  # the kernel, which the maps do without

    path, source = Path(args.output), Source(Path(args.tables))
    folder = path.with_suffix("")
    common.check_page(path, args.force, folder)
    common.check_tables(source.tables, "outlook")
    if lacks := missing(source):
        raise InputError(f"{source.tables} lacks {', '.join(lacks)}; `make outlook` makes them")
    common.check_pictures(pictures(folder), NAME, args.force)
    return common.build_page(path, partial(build, source))
