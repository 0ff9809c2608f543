"""`best TABLE -o PICTURE`: the lowest ke_ratio over all impacts, and the impact that gave it."""

import argparse
from typing import Any

import numpy as np

from analysis import draw, notes, report
from analysis.best import best, competing
from analysis.commands import common
from analysis.optimum import optimum
from analysis.output import write
from analysis.table import IMPACT


def add(commands: Any) -> None:
    """Add this command to the command line."""
    command = commands.add_parser("best", help="lowest ke_ratio over all impacts, and the impact that gave it")
    common.add_picture(command, "the colours of ke_ratio")
    common.add_table(command)
    command.add_argument("--chaotic-too", action="store_true", help="let chaotic rows compete with the others")
    command.set_defaults(command=_best, name="best")


def _best(args: argparse.Namespace) -> list[str]:
    out, table, look = common.begin(args)
    used = competing(table, chaotic_too=args.chaotic_too)
    cells = best(used, chaotic_too=True)  # those left out are already out
    impacts = {name: np.unique(used[name].to_numpy()) for name in IMPACT}
    behind = notes.of_best(table, used, cells, args.chaotic_too)
    write(out, draw.best_maps(cells, impacts, behind, look), cells, look)
    found = f"optimum   {optimum(used, chaotic_too=args.chaotic_too)}"
    return [
        *report.rows_used(table, used, cells, behind),
        found,
        *report.lowest(cells, behind),
        *common.paths(args.table, out),
    ]
