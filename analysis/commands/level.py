"""`level TABLE -o PICTURE`: where a quantity crosses a level along one axis."""

import argparse
from typing import Any

import pandas as pd

from analysis import report
from analysis.chain import chain_of
from analysis.checks import inputs
from analysis.commands import common
from analysis.draw_level import LINES_MAX, level_figure
from analysis.level import crossings, unsure_of
from analysis.notes import hidden_text, skipped_text, without_text
from analysis.output import write
from analysis.panel import placed, symbol
from analysis.part import part_of
from analysis.quantity import KE, quantity
from analysis.searched import search_of
from analysis.table import left_out
from analysis.ticks import label
from sweep.errors import InputError
from sweep.plan.crossing import FIRST, LAST

# What is drawn across: the axis of most values, of several with as many the first of these.
ORDER = ("zeta_T", "V_over_V0", "M_over_M0", "N")


def add(commands: Any) -> None:
    command = commands.add_parser("level", help="where a quantity crosses a level along one axis, over another one")
    common.add_picture(command, "the axis along which it is crossed")
    common.add_table(command)
    common.add_at(command)
    text = 'default: that of the table\'s search, find = "level"'
    command.add_argument("--level", type=float, metavar="X", help=f"the level; {text}")
    command.add_argument("--along", metavar="AXIS", help=f"the axis; {text}, or N")
    command.add_argument("--of", metavar="COLUMN", help=f"the quantity; {text}, or {KE.ratio}")
    command.add_argument("--crossing", choices=(FIRST, LAST), help=f"as the axis rises; {text}, or {FIRST}")
    command.set_defaults(command=_level)


def _level(args: argparse.Namespace) -> list[str]:
    out, table, look = common.begin(args, None)
    asked = search_of(args.table) or {}
    asked = asked if asked.get("find") == "level" else {}
    along, of = args.along or asked.get("along", "N"), args.of or asked.get("of", KE.ratio)
    level = _searched(asked, of, args.table) if args.level is None else args.level
    which = args.crossing or asked.get("crossing", FIRST)
    some, taken = common.at_values(args, table)
    found = crossings(some, level, along, of, which)
    others_of = [name for name in inputs(table) if name != along]
    across, others = _places(found, others_of, args.table)
    what = f"the {which} crossing of {of} = {label(level)} along {along}"
    part = part_of(args.table, table, some)
    title, meaning = _told(of)
    alike = placed({name: found[name].iloc[0] for name in others_of if len(found[name].unique()) == 1})
    verb = "Shown" if (found["why_not"] == "").any() else "Sought"
    shown = f"{verb} is the {which} crossing of {title} = {label(level)} along {symbol(along)}"
    shown = ", at ".join(filter(None, (shown, alike)))
    reasons = left_out(some, of)
    hidden, chain = hidden_text(found, "crossing"), chain_of(args.table, some)
    skipped, without = skipped_text(found, "crossing", along), without_text(reasons)
    text = " ".join(filter(None, (f"{shown}.", meaning, skipped, chain, *part.values(), without, hidden)))
    ends = some[along]
    write(out, level_figure(found, along, across, others, text, look, (ends.min(), ends.max())), found, look)
    return [
        *taken,
        *report.rows_lines(some, report.used_of_lines(found, reasons), part),
        f"lines     {len(found)}, {(found['why_not'] == '').sum()} with {what}{report.lines_without(found)}",
        *report.part_lines({"skipped": skipped, "hidden": hidden}),
        *_ends(found, [across, *others], along),
        *common.paths(args.table, out),
    ]


def _searched(asked: dict[str, Any], of: str, table: str) -> Any:
    """The level of the table's search; InputError where it has none of this quantity."""
    if not asked:
        raise InputError(f'{table}: give --level, as it is not the table of a search with find = "level"')
    if of != (searched := asked.get("of", KE.ratio)):
        raise InputError(f"{table}: give --level, as the search's, {asked.get('level')}, is of {searched}, not of {of}")
    return asked.get("level")


def _told(of: str) -> tuple[str, str]:
    """A column beside an equals sign, and what it is; its name where it belongs to no quantity."""
    try:
        known = quantity(of)
    except InputError:
        return of, ""
    return known.title.partition(" (")[0], known.meaning


def _places(found: pd.DataFrame, inputs: list[str], table: str) -> tuple[str, list[str]]:
    """The axis to draw across, and the others that vary; InputError where there are too many curves."""
    counts = {name: len(found[name].unique()) for name in (*ORDER, *inputs) if name in inputs}
    across = max(counts, key=lambda name: counts[name])
    others = [name for name in counts if counts[name] > 1 and name != across]
    curves = len(found.groupby(others)) if others else 1
    if curves > LINES_MAX:
        what = f"{curves} curves, of {', '.join(others)}"
        way = f"fix a value, as in --at {others[0]}=VALUE"
        raise InputError(f"{table}: would draw {what}; at most {LINES_MAX} can be told apart: {way}")
    return across, others


def _ends(found: pd.DataFrame, varied: list[str], along: str) -> list[str]:
    """The smallest and the largest place of a crossing; how many are not sure."""
    crossed = found[found["why_not"] == ""]
    if crossed.empty:
        return []
    rows = crossed.loc[[crossed["high"].idxmin(), crossed["high"].idxmax()]].to_dict("records")
    lines = [
        f"{word:9} {along} from {row['low']:.6g} to {row['high']:.6g} at "
        + ", ".join(f"{name} = {row[name]:.4g}" for name in varied)
        for word, row in zip(("smallest", "largest"), rows, strict=True)
    ]
    unsure = unsure_of(crossed)
    more = f"unsure    {unsure}, where an end of the bracket is the level within its error"
    return [*lines, *([more] if unsure else [])]
