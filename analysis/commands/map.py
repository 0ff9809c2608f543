"""`map TABLE -o PICTURE`: the ratio of a quantity over two parameters."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from analysis import draw, notes, report
from analysis.checks import model_axes
from analysis.commands import common
from analysis.errors import InputError
from analysis.inferred import COLUMN, inferred
from analysis.output import write
from analysis.plane import check_names, plane_of, same
from analysis.quantity import quantity
from analysis.ruler import ruler
from analysis.scatter import refuse_points
from analysis.searched import said
from analysis.table import finished
from kernel.task import is_number_of_model
from sweep.schema import PARAMETERS


def add(commands: Any) -> None:
    """Add this command to the command line."""
    command = commands.add_parser("map", help="ke_ratio, or another ratio, over two parameters")
    common.add_picture(command, "the colours of the ratio")
    common.add_table(command)
    common.add_over(command)
    command.add_argument(
        "--at", action="extend", nargs="+", default=[], metavar="NAME=VALUE", help="fix a parameter at a value"
    )
    common.add_of(command)
    command.set_defaults(command=_map, name="map")


def _map(args: argparse.Namespace) -> list[str]:
    over, at, of = tuple(args.over.split(",")), _pairs(args.at), quantity(args.of)
    check_names([name for name in (*over, *at) if not is_number_of_model(name)])
    out, table, look = common.begin(args)
    check_names((*over, *at), [*PARAMETERS, *model_axes(table)])
    refuse_points(table, over)
    at, taken = _taken(table, at)
    cells = plane_of(of, table, over, at)
    if not cells[of.ratio].notna().any():
        raise InputError(f"no finished row of this map has a {of.ratio}")
    searched = said(args.table, table)
    behind = replace(notes.of_plane(table, cells, over, at, of), said=searched)
    between = inferred(args.table, table, of)
    drawn = cells if between is None else _with(cells, plane_of(of, between, over, at), over)
    write(out, draw.plane_map(drawn, over, behind, look), drawn, look)
    return [
        *taken,
        *report.plane_used(table, cells, over, behind),
        *([f"search    {searched}"] if searched else []),
        *report.lowest(cells, behind),
        *common.paths(args.table, out),
    ]


def _with(cells: pd.DataFrame, between: pd.DataFrame, over: Sequence[str]) -> pd.DataFrame:
    """The computed cells and those that were interpolated, in one frame."""
    parts = [frame.assign(**{COLUMN: flag}) for frame, flag in ((cells, False), (between, True)) if len(frame)]
    return pd.concat(parts).sort_values(list(over), kind="stable")


def _pairs(texts: Sequence[str]) -> dict[str, float]:
    """The values by name of texts NAME=VALUE; InputError names each text that is none, or repeats a name."""
    values: dict[str, float] = {}
    problems = []
    for text in texts:
        name, _, number = text.partition("=")
        try:
            value = float(number)
        except ValueError:
            problems.append(f"--at {text}: write NAME=VALUE with a number, for example N=200")
            continue
        if name in values:
            problems.append(f"--at gives {name} twice")
        values[name] = value
    if problems:
        raise InputError(*problems)
    return values


def _taken(table: pd.DataFrame, at: Mapping[str, float]) -> tuple[dict[str, float], list[str]]:
    """Replace each value by the table's whose cell on the map holds it, with a line to print for each that changes.

    A value that is in no cell stays as it is; `plane_of` then refuses it and lists the table's.
    """
    found, lines = dict(at), []
    rows = finished(table)
    for name, value in at.items():
        values = np.unique(rows[name].dropna().to_numpy(np.float64))
        cells = ruler(values).cells if len(values) else np.empty((0, 2))
        inside = np.flatnonzero((cells[:, 0] <= value) & (value <= cells[:, 1]))
        if value in values or not len(inside) or (value == 0) != (values[inside[0]] == 0):
            continue
        found[name] = float(values[inside[0]])
        if not same(found[name], value):
            lines.append(f"at        {name} = {found[name]!r}, which is nearest to {value:g}")
    return found, lines
