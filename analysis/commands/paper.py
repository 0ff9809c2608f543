"""`paper -o PAGE`: every figure and number of the paper beside ours, as one HTML page."""

import argparse
import sys
from pathlib import Path
from typing import Any

from analysis.commands import common
from analysis.errors import InputError


def add(commands: Any) -> None:
    """Add this command to the command line."""
    page = commands.add_parser("paper", help="every figure and number of the paper beside ours, as one HTML page")
    page.add_argument("-o", dest="output", metavar="PAGE", default="paper.html", help="default: %(default)s")
    page.add_argument(
        "--tables", metavar="DIR", default="paper", help="where `make paper` put fig4.h5, .. (%(default)s)"
    )
    page.add_argument(
        "--jobs", metavar="DIR", default="jobs/paper", help="where scenes/fig2.toml, .. lie (%(default)s)"
    )
    page.add_argument("--force", action="store_true", help="replace files that are not as this program left them")
    page.set_defaults(command=_paper)


def _paper(args: argparse.Namespace) -> list[str]:
    from analysis.paper.page import build  # the kernel, which the maps do without
    from analysis.paper.recipe import Source

    path, source = Path(args.output), Source(Path(args.tables), Path(args.jobs))
    _check(path, source, args.force)
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    page = build(source, folder, progress=lambda text: print(text, file=sys.stderr))
    return [*page.lines, common.write_page(path, page.html), f"pictures  {folder}/*.png, *.csv"]


def _check(path: Path, source: Any, force: bool) -> None:
    """Check, before anything is computed, that tables and scenes are there and that the page may be written."""
    from analysis.paper.page import NAME, pictures

    common.check_page(path, force, path.with_suffix(""))
    if not source.tables.is_dir():
        raise InputError(f"there is no directory {source.tables} with tables; `make paper` makes it")
    if not (source.jobs / "scenes").is_dir():
        raise InputError(f"there is no directory {source.jobs / 'scenes'} with scene files")
    common.check_pictures(pictures(path.with_suffix("")), NAME, force)
