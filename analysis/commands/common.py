"""What the commands share: the table to read, where the picture goes and how it looks, the lines at the end."""

import argparse
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from analysis.at import nearest, pairs
from analysis.checks import inputs, require
from analysis.exported import read_exported
from analysis.look import Look
from analysis.options import look
from analysis.output import Output, output
from analysis.plane import check_names, chosen
from analysis.quantity import KE, Quantity, quantity, ratio, shown_by
from analysis.reading import is_csv
from analysis.searched import search_of
from analysis.streamed import grid_of_large, rows_at
from analysis.table import DONE_LABEL, finished, load, no_finished_row, reused_text, wall_seconds
from sweep.errors import InputError, gathered, refuse_all
from sweep.files import page_problem, replacing
from sweep.schema import PARAMETERS

# Their pictures have their numbers in PICTURE.COMMAND.csv: the rows that won, lines, or rows with columns left out.
PICTURES = ("best", "map", "points", "transition", "level", "collapse", "tradeoff", "atlas")

NOTHING: Mapping[str, float] = MappingProxyType({})
OVER = "N,zeta_T"  # the axes of a picture, unless others are asked for


def add_picture(command: argparse.ArgumentParser, quantity: str) -> None:
    """Add `-o PICTURE` and the options of its look; --limits are those of `quantity`."""
    text = ".png, .pdf or .svg; its numbers go beside it, to PICTURE's stem.COMMAND.csv"
    command.add_argument("-o", dest="output", metavar="PICTURE", required=True, help=text)
    command.add_argument("--force", action="store_true", help="replace files that are not as this program left them")
    group = command.add_argument_group("look")
    group.add_argument("--limits", metavar="LOW,HIGH", help=f"of {quantity}, such as 0.01,1")
    group.add_argument("--cmap", metavar="NAME", help="matplotlib's colour map, for colours and for curves")
    group.add_argument("--size", metavar="W,H", help="width and height of the picture in inches (of 2.54 cm)")
    group.add_argument("--title", metavar="TEXT", help="above the picture")
    group.add_argument("--dpi", metavar="N", help=f"pixels per inch, default: {Look().dpi}")
    command.set_defaults(tells_wrong=True)


def add_table(command: argparse.ArgumentParser) -> None:
    """Add the argument `TABLE`."""
    text = "table written by `sweep run`, finished or not, or a .csv that `sweep export` made of it"
    command.add_argument("table", metavar="TABLE", help=text)


def add_over(command: argparse.ArgumentParser) -> None:
    """Add `--over`, the two axes of a picture."""
    text = f"two of {', '.join(PARAMETERS)}, spring.c2 ..; default: %(default)s"
    command.add_argument("--over", default=OVER, metavar="ACROSS,UP", help=text)


def add_at(command: argparse.ArgumentParser) -> None:
    """Add `--at`, the values of other parameters."""
    text = "fix a parameter; a value that the table has not is taken for the one whose cell holds it"
    command.add_argument("--at", action="extend", nargs="+", default=[], metavar="NAME=VALUE", help=text)


def at_values(args: argparse.Namespace, table: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """The rows with the values that `--at` names, and a line to print for each value that is not as it was typed."""
    at = pairs(args.at)
    check_names(list(at), inputs(table))
    require(table, list(at))  # an edited .csv may lack a parameter
    values, lines = nearest(table, at)
    return chosen(table, values), lines


_COLUMNS: dict[Callable[[str], Quantity], str] = {
    ratio: "ke_ratio, or q_ratio",
    quantity: "ke_ratio, or q_ratio, q or q_linear",
    shown_by: "ke_ratio, ke_bistable or ke_linear, or q_ratio, q or q_linear",
}


def add_of(command: argparse.ArgumentParser, known: Callable[[str], Quantity], searched: str = "") -> None:
    """Add `--of`, the column that is drawn or judged; `searched`: the kind of search whose column is the default."""
    text = f"{_COLUMNS[known]} of a quantity q that the spec observes"
    default = f'that of the table\'s search, find = "{searched}", or {KE.ratio}' if searched else KE.ratio
    command.add_argument(
        "--of", default=None if searched else KE.ratio, metavar="COLUMN", help=f"{text}; default: {default}"
    )


def of_asked(args: argparse.Namespace, searched: str, known: Callable[[str], Quantity]) -> Quantity:
    """What --of names; without it what the table's search of this kind looks for, where a picture can show that."""
    if args.of is None and Path(args.table).is_file():
        search = search_of(args.table) or {}
        if search.get("find") == searched:
            with suppress(InputError):
                return known(search.get("of", KE.ratio))
    return known(KE.ratio if args.of is None else args.of)


def begin(args: argparse.Namespace, known: Callable[[str], Quantity] | None = shown_by) -> tuple[Any, ...]:
    """The checked output, all rows of the table, and the look; InputError with all that is wrong with the options.

    known: the quantity of a column that `--of` may name; None: any column.
    """
    of = None if known is None or args.of is None else partial(known, args.of)
    (out, wanted), table, _ = gathered(lambda: output_of(args), lambda: _fitting(args, of), lambda: of and of())
    return out, table, wanted


def output_of(args: argparse.Namespace) -> tuple[Output, Look]:
    """The checked output and the look, of a command with or without a table."""
    wanted, out, _ = gathered(
        lambda: look(args),
        lambda: output(args.output, args.name, getattr(args, "table", None), args.force),
        lambda: refuse_all(args.wrong),
    )
    return out, wanted


def _fitting(args: argparse.Namespace, of: Callable[[], Quantity] | None) -> pd.DataFrame:
    """The rows of a table; InputError where --over, --at and --of do not fit them."""
    at, over = pairs(args.at), args.over.split(",") if "over" in args else []
    table = read(Path(args.table), at)
    names = inputs(table)
    fixed = {name: value for name, value in at.items() if name in names and name in table}
    gathered(
        lambda: check_names([*over, *at], names),
        lambda: chosen(table, nearest(table, fixed)[0]),
        lambda: _refuse_lacking(table, args.of, () if of is None else (of().error,)),
    )
    return table


def _refuse_lacking(table: pd.DataFrame, column: str | None, error: tuple[str, ...]) -> None:
    if column is not None and column not in table:  # of what is there the command tells all columns that it needs
        require(table, (column, *error))


def read(path: Path, at: Mapping[str, float] = NOTHING) -> pd.DataFrame:
    """The rows of a table, or of a .csv; InputError where none is finished, or where they are a picture's numbers.

    Of a table that is too large for memory only those with the values `at`, of any other one all.
    """
    _refuse_numbers(path)
    table = rows_of(path, at)
    if "status" in table and finished(table).empty:
        raise no_finished_row(path, table["status"])
    return table


def _refuse_numbers(path: Path) -> None:
    """InputError for a file PICTURE.COMMAND.csv, unless it holds whole rows."""
    *_, command, _ = ("", *path.name.split("."))
    if not is_csv(path) or command not in PICTURES or not path.is_file():
        return
    with path.open(encoding="utf-8", errors="replace") as file:
        whole = "method" in file.readline().strip().split(",")
    if not whole:
        what = f"the numbers of a picture that `analysis {command}` drew, not the rows of a table"
        raise InputError(f"{path} holds {what}: give the table")


def rows_of(path: Path, at: Mapping[str, float] = NOTHING) -> pd.DataFrame:
    """The same, whether or not any row is finished."""
    if is_csv(path):
        return _csv(path)
    grid = grid_of_large(str(path))
    return load(path, done_only=False) if grid is None else rows_at(path, grid, at)


def _csv(path: Path) -> pd.DataFrame:
    table = read_exported(path)
    if table.empty:  # as an export of what is not computed yet, whose columns hold no numbers
        raise no_finished_row(path, pd.Series([], dtype=str))
    table = table.set_index("task") if "task" in table else table
    return table if "status" in table else table.assign(status=DONE_LABEL)


def paths(table: str, out: Output) -> list[str]:
    """The last lines to print: the table and the files written."""
    text = "" if is_csv(table) else _computed(table)
    return [f"table     {table}{text}", *files(out)]


def _computed(table: str) -> str:
    """How long the table took, and how many rows were taken over from others."""
    seconds, taken = wall_seconds(table), reused_text(table)
    text = "" if seconds is None else f", computed in {seconds:.1f} s without start and compiling"
    return f"{text}, {taken}" if taken else text


def add_page_of_tables(command: Any, name: str, table: str) -> None:
    """Give a command its page, the folder in which `make NAME` put its tables, such as `table`, and --force."""
    command.add_argument("-o", dest="output", metavar="PAGE", default=f"{name}.html", help="default: %(default)s")
    where = f"where `make {name}` put {table}, .. (%(default)s)"
    command.add_argument("--tables", metavar="DIR", default=name, help=where)
    command.add_argument("--force", action="store_true", help="replace files that are not as this program left them")


def page_of_tables(args: argparse.Namespace, of: Any, source: Any) -> list[str]:
    """Write a page and, beside it, the folder of its pictures; the lines to print of both.

    `of`: analysis.paper.page, or another module with NAME, lacks, pictures and build. All that can be is checked before
    anything is computed.
    """
    path, folder = Path(args.output), Path(args.output).with_suffix("")
    check_page(path, args.force, folder)
    if not source.tables.is_dir():
        raise InputError(f"there is no directory {source.tables} with tables; `make {of.NAME}` makes it")
    if lacks := of.lacks(source):
        raise InputError(lacks)
    there = [picture for picture in of.pictures(folder) if picture.parent.is_dir()]
    gathered(*(partial(output, picture, of.NAME, force=args.force) for picture in there))
    folder.mkdir(exist_ok=True)
    page = of.build(source, folder, progress=lambda text: print(text, file=sys.stderr))
    return [*page.lines, write_page(path, page.html), f"pictures  {folder}/*.png, *.csv"]


def check_page(path: Path, force: bool, pictures: Path | None = None) -> None:
    """InputError unless a page, and beside it the folder of its `pictures`, may be written."""
    if problem := page_problem(path, force, pictures):
        raise InputError(f"-o: {problem}")


def write_page(path: Path, text: str) -> str:
    """Write a page, whole or not at all; the line to print of it."""
    try:
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from None
    return f"page      {path} ({path.stat().st_size / 1e6:.1f} MB)"


def files(out: Output) -> list[str]:
    """The files written."""
    return [f"picture   {out.picture}", f"numbers   {out.csv}"]
