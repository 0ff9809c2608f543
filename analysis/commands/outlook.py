"""`outlook -o PAGE`: what the paper leaves open, asked of tables of other laws, figures of merit and disorder."""

import argparse
from pathlib import Path
from typing import Any

from analysis.commands import common


def add(commands: Any) -> None:
    page = commands.add_parser("outlook", help="what the paper leaves open: questions, rules and answers on one page")
    common.add_page_of_tables(page, "outlook", "threshold.h5")
    page.set_defaults(command=_outlook)


def _outlook(args: argparse.Namespace) -> list[str]:
    from analysis.outlook import page
    from analysis.paper import recipe  # the kernel, which the maps do without

    return common.page_of_tables(args, page, recipe.Source(Path(args.tables)))
