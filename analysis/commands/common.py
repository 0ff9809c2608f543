"""What the commands share: the table to read, where the picture goes, what is told at the end."""

import argparse

import pandas as pd

from analysis.output import Output, output
from analysis.table import done_rows, finished, load, no_finished_row, reused, wall_seconds


def add_picture(command: argparse.ArgumentParser) -> None:
    """`-o PICTURE`."""
    command.add_argument(
        "-o", dest="output", metavar="PICTURE", required=True, help=".png, .pdf or .svg; a .csv goes beside it"
    )


def add_table(command: argparse.ArgumentParser) -> None:
    """`TABLE`."""
    command.add_argument("table", metavar="TABLE", help="table written by `sweep run`, finished or not")


def begin(args: argparse.Namespace) -> tuple[Output, pd.DataFrame]:
    """Where to write, and all rows of the table; InputError where there is nothing to draw or nowhere to write."""
    out = output(args.output, args.table)
    table = load(args.table, done_only=False)
    if finished(table).empty:
        raise no_finished_row(args.table, table["status"])
    return out, table


def paths(table: str, out: Output) -> list[str]:
    """Where it came from and where it went."""
    seconds = wall_seconds(table)
    computed = "" if seconds is None else f", computed in {seconds:.1f} s of wall time"
    if taken := reused(table):
        computed += f", {sum(taken.values())} of {done_rows(table)} rows taken over from {', '.join(taken)}"
    return [f"table     {table}{computed}", *files(out)]


def files(out: Output) -> list[str]:
    """Where it went."""
    return [f"picture   {out.picture}", f"numbers   {out.csv}"]
