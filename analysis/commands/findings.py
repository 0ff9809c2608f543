"""`findings TABLE ...`: which of the paper's five key findings hold on each table, with the numbers."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from analysis import report
from analysis.at import pairs
from analysis.commands import common
from analysis.paper.findings import findings
from analysis.part import part_of
from analysis.quantity import KE, Quantity, ratio
from sweep.errors import InputError

# What of a table (`part_of`) leaves every finding open, and why.
OPEN = {
    "shard": "needs the rows of all shards, which `sweep merge` joins into one table",
    "chosen": "needs the rows that the search left out, too",
}


def add(commands: Any) -> None:
    command = commands.add_parser("findings", help="which of the paper's five key findings hold on a table")
    text = "table written by `sweep run`, finished or not; or a .csv: an exported one, or fig11.paper.csv for finding 4"
    command.add_argument("tables", metavar="TABLE", nargs="+", help=text)
    common.add_at(command)
    common.add_of(command, ratio)
    command.set_defaults(command=_findings)


def _findings(args: argparse.Namespace) -> list[str]:
    of, lines, problems = ratio(args.of), [], []
    for path in map(Path, args.tables):
        try:
            lines += _lines(path, args, of)
        except InputError as error:
            problems.append(str(error) if str(path) in str(error) else f"{path}: {error}")
    if problems:
        raise InputError(*problems)
    if not any(line.startswith("finding 4") for line in lines):
        lines.append("finding 4 needs profiles of waves, which are in no table: give fig11.paper.csv of `make paper`")
    return lines


def _lines(path: Path, args: argparse.Namespace, of: Quantity) -> list[str]:
    whole = common.read(path, pairs(args.at))
    table, taken = common.at_values(args, whole)
    part = part_of(path, whole, table)
    lines = [f"table     {path}", *taken, *report.part_lines(part)]
    why = next((why for word, why in OPEN.items() if word in part), "")
    if of != KE:
        lines.append(f"of        {of.ratio} in place of {KE.ratio}: the lower, the better")
    for found in findings(table, of.ratio):
        one = replace(found, holds=None, why=why) if why else found
        rule = "lacks" if one.holds is None else "rule"
        lines += [f"finding {one.number} {one.verdict}: {one.claim}", f"  numbers {one.text}", f"  {rule:8}{one.why}"]
    return lines
