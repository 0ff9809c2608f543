"""The command line: `python -m analysis best|map TABLE -o PICTURE`."""

import argparse
import sys
from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis import draw, report
from analysis.best import best, competing
from analysis.errors import InputError
from analysis.output import Output, output, write
from analysis.plane import plane
from analysis.table import finished, load, no_finished_row, wall_seconds
from sweep.schema import PARAMETERS


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; 0 if picture and CSV were written, 2 for bad input (one line on stderr)."""
    args = _parser().parse_args(argv)
    try:
        lines = args.command(args)
    except (InputError, OSError) as error:
        print(f"analysis: {error}", file=sys.stderr)
        return 2
    print("\n".join(lines))
    return 0


def _best(args: argparse.Namespace) -> list[str]:
    out, table = _begin(args)
    used = competing(table, chaotic_too=args.chaotic_too)
    cells = best(used, chaotic_too=True)  # those left out are already out
    impacts = {name: np.unique(used[name].to_numpy()) for name in ("M_over_M0", "V_over_V0")}
    write(out, draw.best_maps(cells, impacts), cells)
    return [*report.rows_used(table, used, cells), *report.lowest(cells), *_paths(args.table, out)]


def _map(args: argparse.Namespace) -> list[str]:
    over = tuple(args.over.split(","))
    at = _values(args.at)
    out, table = _begin(args)
    cells = plane(table, over, at)
    if not cells["ke_ratio"].notna().any():
        raise InputError("no finished row of this map has a ke_ratio")
    write(out, draw.plane_map(cells, over), cells)
    return [*report.plane_used(table, cells, over), *report.lowest(cells), *_paths(args.table, out)]


def _begin(args: argparse.Namespace) -> tuple[Output, pd.DataFrame]:
    out = output(args.output, args.table)
    table = load(args.table, done_only=False)
    if finished(table).empty:
        raise no_finished_row(args.table, table["status"])
    return out, table


def _values(pairs: Sequence[str]) -> dict[str, float]:
    values: dict[str, float] = {}
    for pair in pairs:
        name, _, text = pair.partition("=")
        try:
            number = float(text)
        except ValueError:
            raise InputError(f"--at {pair}: write NAME=VALUE with a number, for example N=200") from None
        if name in values:
            raise InputError(f"--at gives {name} twice")
        values[name] = number
    return values


def _paths(table: str, out: Output) -> list[str]:
    seconds = wall_seconds(table)
    computed = "" if seconds is None else f", computed in {seconds:.1f} s of wall time"
    return [f"table     {table}{computed}", f"picture   {out.picture}", f"numbers   {out.csv}"]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="analysis", description="Maps from a table of results.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("table", metavar="TABLE", help="table written by `sweep run`, finished or not")
    common.add_argument(
        "-o",
        dest="output",
        metavar="PICTURE",
        required=True,
        help=".png, .pdf or .svg; a .csv goes beside it",
    )
    one = commands.add_parser(
        "best", parents=[common], help="lowest ke_ratio over all impacts, and the impact that gave it"
    )
    one.add_argument("--chaotic-too", action="store_true", help="let chaotic rows compete with the others")
    one.set_defaults(command=_best)
    two = commands.add_parser("map", parents=[common], help="ke_ratio over two parameters")
    two.add_argument("--over", default="N,zeta_T", metavar="ACROSS,UP", help=f"two of {', '.join(PARAMETERS)}")
    two.add_argument(
        "--at",
        action="extend",
        nargs="+",
        default=[],
        metavar="NAME=VALUE",
        help="fix a parameter at a value",
    )
    two.set_defaults(command=_map)
    return parser
