"""`map TABLE -o PICTURE`: the ratio of a quantity over two parameters."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from analysis import draw, notes, report
from analysis.at import nearest, pairs
from analysis.chain import alike_in, chain_of
from analysis.checks import inputs, require
from analysis.commands import common
from analysis.output import write
from analysis.part import axes_of, part_of
from analysis.plane import chosen, plane_of, same
from analysis.quantity import shown_by
from analysis.scatter import refuse_points
from analysis.sought import COLUMN, inferred
from sweep.errors import InputError
from sweep.schema import PARAMETERS


def add(commands: Any) -> None:
    command = commands.add_parser("map", help="ke_ratio, or another ratio, over two parameters")
    common.add_picture(command, "the colours of the ratio")
    common.add_table(command)
    common.add_over(command)
    common.add_at(command)
    common.add_of(command, shown_by, "map")
    command.set_defaults(command=_map)


def _map(args: argparse.Namespace) -> list[str]:
    out, table, look = common.begin(args)
    over, of = tuple(args.over.split(",")), common.of_asked(args, "map", shown_by)
    require(table, (*PARAMETERS, of.ratio, of.error))
    refuse_points(table, over)
    at, taken = nearest(table, pairs(args.at))
    cells = plane_of(of, table, over, at)
    if not cells[of.ratio].notna().any():
        raise InputError(f"no finished row of this map has a {of.ratio}")
    part = part_of(args.table, table, chosen(table, at), of.ratio)
    at = {name: float(cells[name].iloc[0]) for name in inputs(table) if name not in over}  # what was left open too
    words = filter(None, (*part.values(), chain_of(args.table, table), alike_in(cells)))
    behind = replace(notes.of_plane(table, cells, over, at, of, axes_of(args.table)), said=" ".join(words))
    between = inferred(args.table, table, of)
    drawn = cells if between is None else _with(cells, _of_plane(between, at), over)
    write(out, draw.plane_map(drawn, over, behind, look), drawn, look)
    return [
        *taken,
        *report.plane_used(table, cells, drawn, over, behind),
        *report.part_lines(part),
        *report.lowest(drawn, behind),
        *common.paths(args.table, out),
    ]


def _of_plane(between: pd.DataFrame, at: Mapping[str, float]) -> pd.DataFrame:
    """What was interpolated in the plane with these values of all other inputs: nothing where all of it is computed."""
    for name, value in at.items():
        between = between[same(between[name], value)]
    return between


def _with(cells: pd.DataFrame, between: pd.DataFrame, over: Sequence[str]) -> pd.DataFrame:
    """The computed cells and those that were interpolated, in one frame."""
    there = between[[name for name in cells if name in between]]  # no row of a guess has a spread
    parts = [frame.assign(**{COLUMN: flag}) for frame, flag in ((cells, False), (there, True)) if len(frame)]
    return pd.concat(parts).sort_values(list(over), kind="stable")
