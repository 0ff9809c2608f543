"""`points TABLE -o PICTURE`: the ratio of rows that form no grid, each a dot where it is."""

import argparse
from dataclasses import replace
from typing import Any

from analysis import notes, report
from analysis.chain import told_of
from analysis.commands import common
from analysis.draw_points import points_figure, stacked
from analysis.output import write
from analysis.part import part_of
from analysis.quantity import shown_by
from analysis.scatter import scattered
from analysis.table import left_out, reasons_text


def add(commands: Any) -> None:
    command = commands.add_parser("points", help="ke_ratio, or another ratio, of rows that form no grid, as dots")
    common.add_picture(command, "the colours of the ratio")
    common.add_table(command)
    common.add_at(command)
    common.add_over(command)
    common.add_of(command, shown_by)
    command.set_defaults(command=_points)


def _points(args: argparse.Namespace) -> list[str]:
    out, whole, look = common.begin(args)
    over, of = tuple(args.over.split(",")), shown_by(args.of)
    table, taken = common.at_values(args, whole)
    part = part_of(args.table, whole, table)
    rows = scattered(table, over, of)
    reasons = left_out(table, of.ratio, chaotic_too=True)
    told = " ".join(filter(None, (*part.values(), notes.without_text(reasons), told_of(args.table, table))))
    said, places = replace(notes.of_points(table, rows, over, of), said=told), stacked(rows, over)
    chaos = said.hatched or said.unchecked or "none of them chaotic"
    used = f"{notes.count(len(rows), 'row')}, each a point; {chaos}"
    write(out, points_figure(rows, over, said, look), rows, look)
    return [
        *taken,
        *report.rows_lines(table, f"{used}; left out: {reasons_text(reasons)}", {"places": places, **part}),
        *report.lowest(rows, said, "point"),
        *common.paths(args.table, out),
    ]
