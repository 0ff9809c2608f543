"""`paper -o PAGE`: every figure and number of the paper beside ours, as one HTML page."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from analysis.commands import common
from analysis.errors import InputError


def add(commands: Any) -> None:
    page = commands.add_parser("paper", help="every figure and number of the paper beside ours, as one HTML page")
    common.add_page_of_tables(page, "paper", "fig4.h5")
    page.add_argument(
        "--jobs", metavar="DIR", default="jobs/paper", help="where scenes/fig2.toml, .. lie (%(default)s)"
    )
    page.set_defaults(command=_paper)


def _paper(args: argparse.Namespace) -> list[str]:
    from analysis.paper.page import build  # the kernel, which the maps do without
    from analysis.paper.recipe import Source

    path, source = Path(args.output), Source(Path(args.tables), Path(args.jobs))
    _check(path, source, args.force)
    return common.build_page(path, partial(build, source))


def _check(path: Path, source: Any, force: bool) -> None:
    """Check, before anything is computed, that tables and scenes are there and that the page may be written."""
    from analysis.paper.page import NAME, pictures

    common.check_page(path, force, path.with_suffix(""))
    common.check_tables(source.tables, "paper")
    if not (source.jobs / "scenes").is_dir():
        raise InputError(f"there is no directory {source.jobs / 'scenes'} with scene files")
    common.check_pictures(pictures(path.with_suffix("")), NAME, force)
