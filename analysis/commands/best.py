"""`best TABLE -o PICTURE`: the lowest ke_ratio, or another ratio, over all impacts, and the impact that gave it."""

import argparse
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from analysis import draw, notes, report
from analysis.at import pairs
from analysis.best import best, competing
from analysis.chain import told_of
from analysis.checks import model_axes, require
from analysis.commands import common
from analysis.optimum import optimum_on
from analysis.output import write
from analysis.part import axes_of, gaps_text, part_of
from analysis.quantity import Quantity, quantity
from analysis.scatter import refuse_points
from analysis.searched import apart, certified, has_seen_all, looked_over, refuse_another, search_of
from analysis.sought import CANDIDATE, candidates, here, words
from analysis.streamed import best_of_grid, grid_of_large
from sweep.errors import gathered
from sweep.plan.tasks import Tasks
from sweep.schema import PARAMETERS


def add(commands: Any) -> None:
    command = commands.add_parser("best", help="lowest ratio over all impacts, and the impact that gave it")
    common.add_picture(command, "the colours of the ratio")
    common.add_table(command)
    common.add_over(command)
    common.add_at(command)
    common.add_of(command, quantity, "lowest")
    command.add_argument("--chaotic-too", action="store_true", help="let chaotic rows compete with the others")
    command.set_defaults(command=_best)


def _best(args: argparse.Namespace) -> list[str]:
    if not args.at and args.over == common.OVER and (grid := grid_of_large(args.table)) is not None:
        return _streamed(args, grid)
    (out, table, look), of = common.begin(args, quantity), _of(args)
    refuse_another(args.table, of.ratio)
    over, robust = tuple(args.over.split(",")), words(search_of(args.table))
    require(table, (of.ratio, of.error))
    rows = certified(args.table, candidates(args.table, table, of) if robust else table)
    rows, taken = common.at_values(args, rows)
    among = [name for name in looked_over(args.table) if name in model_axes(rows) and name not in over]
    which: Any = {"over": over, "of": of.ratio, "among": among}
    used = competing(rows, chaotic_too=args.chaotic_too, **which)
    refuse_points(table, over, several=True)
    cells = best(used, chaotic_too=True, **which)  # those left out are already out
    cells = cells.join(rows[here(of)]) if robust else cells
    axes = axes_of(args.table, fixed=pairs(args.at))
    every = common.at_values(args, table)[0]
    part = part_of(args.table, table, every)
    if "shard" not in part and (gaps := gaps_text(every)):
        part["absent"] = gaps
    fixed = [name for name in pairs(args.at) if len(table[name].unique()) > 1]
    cells_of = [*over, *fixed]
    if mixed := apart(args.table, cells_of):
        part["search"] = f"{part.get('search', '')} {mixed}".strip()
    scanned = {name: axes.get(name, rows[name].to_numpy()) for name in (*PARAMETERS, *among) if name not in over}
    others = {name: np.unique(values) for name, values in scanned.items()}
    what, means = ("candidate", CANDIDATE) if robust else ("row", "")
    behind = notes.of_best(rows, used, cells, args.chaotic_too, over, of, axes, what)
    words_below = " ".join(filter(None, (*part.values(), told_of(args.table, rows), means, behind.said)))
    lacking = "failed" in part or (bool(part) and not has_seen_all(args.table, cells_of))
    behind = replace(behind, said=words_below, lacking=lacking)
    if robust:
        behind = replace(behind, of=replace(of, title=f"{of.title} ({robust})"))
    write(out, draw.best_maps(cells, others, behind, look, over), cells, look)
    found = f"optimum   {optimum_on(axes, rows, chaotic_too=args.chaotic_too, **which)}"
    # The interval holds rivals among the rows that are there, and nothing of the others.
    if part:
        lowest_known = set(part) == {"search"} and has_seen_all(args.table, fixed)
        found += f"; among the rows computed: others may be {'as low' if lowest_known else 'lower'}"
    return [
        *taken,
        *report.rows_used(rows, used, cells, behind, over, what),
        *report.part_lines(part),
        *([_needle(cells, robust, of)] if robust else []),
        found,
        *report.left_out_lower(used, rows, of, what),
        *report.lowest(cells, behind),
        *common.paths(args.table, out),
    ]


def _of(args: argparse.Namespace) -> Quantity:
    return common.of_asked(args, "lowest", quantity)


def _streamed(args: argparse.Namespace, grid: Tasks) -> list[str]:
    """Of a table that is too large for memory."""
    of, (out, look) = gathered(lambda: _of(args), lambda: common.output_of(args))
    found = best_of_grid(args.table, grid, args.chaotic_too, of)
    write(out, draw.best_maps(found.cells, found.impacts, found.notes, look), found.cells, look)
    taken = common.paths(args.table, out)
    return [*found.lines, *report.lowest(found.cells, found.notes), *taken]


def _needle(cells: pd.DataFrame, robust: str, of: Quantity) -> str:
    """How much is lost around the best impacts, where what counts is not their own ratio."""
    loss = cells[of.ratio] / cells[here(of)]
    middle, most = float(loss.median()), float(loss.max())
    return (
        f"robust    {robust}: {middle:.3g} times the ratio of the impact itself in the median cell, at most {most:.3g}"
    )
