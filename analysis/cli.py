"""The command line: `python -m analysis best|map TABLE -o PICTURE`, `tradeoff|atlas -o PICTURE`."""

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


def _tradeoff(args: argparse.Namespace) -> list[str]:
    from analysis import draw_tradeoff, tradeoff, tradeoff_text  # the kernel, which the maps do without

    out = output(args.output)
    tasks, left_out = tradeoff.sample(args.tasks, args.seed)
    points = tradeoff.tradeoff(tasks)
    write(out, draw_tradeoff.tradeoff_figure(points, len(tasks)), points)
    told = f"sample    {len(tasks)} random tasks of the paper's domain, seed {args.seed}"
    return [f"{told}; left out: {left_out} ill-conditioned", *tradeoff_text.headlines(points), *_files(out)]


def _atlas(args: argparse.Namespace) -> list[str]:
    from analysis import atlas, draw_atlas

    out = output(args.output)
    cells = atlas.atlas(args.side)
    write(out, draw_atlas.atlas_figure(cells), cells)
    return [*atlas.headlines(cells), *_files(out)]


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
    return [f"table     {table}{computed}", *_files(out)]


def _files(out: Output) -> list[str]:
    return [f"picture   {out.picture}", f"numbers   {out.csv}"]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="analysis", description="Maps from a table of results.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    picture = argparse.ArgumentParser(add_help=False)
    picture.add_argument(
        "-o",
        dest="output",
        metavar="PICTURE",
        required=True,
        help=".png, .pdf or .svg; a .csv goes beside it",
    )
    common = argparse.ArgumentParser(add_help=False, parents=[picture])
    common.add_argument("table", metavar="TABLE", help="table written by `sweep run`, finished or not")
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
    three = commands.add_parser(
        "tradeoff", parents=[picture], help="work against precision of every method, measured now on random tasks"
    )
    three.add_argument("--tasks", type=int, default=60, metavar="N", help="default: %(default)s")
    three.add_argument("--seed", type=int, default=1, help="of the sample, default: %(default)s")
    three.set_defaults(command=_tradeoff)
    four = commands.add_parser(
        "atlas", parents=[picture], help="which scheme auto takes where, its step, and where the chaos is"
    )
    four.add_argument("--side", type=int, default=24, metavar="N", help="cells per axis, default: %(default)s")
    four.set_defaults(command=_atlas)
    return parser
