"""`paper -o PAGE`: every figure and number of the paper beside ours, as one HTML page."""

import argparse
from pathlib import Path
from typing import Any

from analysis.commands import common


def add(commands: Any) -> None:
    page = commands.add_parser("paper", help="every figure and number of the paper beside ours, as one HTML page")
    common.add_page_of_tables(page, "paper", "fig4.h5")
    page.add_argument(
        "--jobs", metavar="DIR", default="jobs/paper", help="where scenes/fig2.toml, .. lie (%(default)s)"
    )
    page.set_defaults(command=_paper)


def _paper(args: argparse.Namespace) -> list[str]:
    from analysis.paper import page, recipe  # the kernel, which the maps do without

    return common.page_of_tables(args, page, recipe.Source(Path(args.tables), Path(args.jobs)))
