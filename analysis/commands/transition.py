"""`transition TABLE -o PICTURE`: N_transition of every damping and impact, and its power law."""

import argparse
from typing import Any

import pandas as pd

from analysis import report
from analysis.chain import is_papers, told_of
from analysis.commands import common
from analysis.draw_transition import exponent, transition_figure
from analysis.notes import hidden_text, skipped_text, without_text
from analysis.output import write
from analysis.paper.numbers import EXPONENTS
from analysis.part import part_of
from analysis.power_law import beside_laws, power_laws
from analysis.quantity import KE, Quantity, ratio
from analysis.table import left_out
from analysis.transition import DEFINITIONS, transition


def add(commands: Any) -> None:
    text = "N_transition against zeta_T, its power law, and how it depends on the definition"
    command = commands.add_parser("transition", help=text)
    common.add_picture(command, "the axis of N_transition")
    common.add_table(command)
    common.add_at(command)
    common.add_of(command, ratio)
    command.set_defaults(command=_transition)


def _transition(args: argparse.Namespace) -> list[str]:
    out, whole, look = common.begin(args, ratio)
    of = ratio(args.of)
    table, taken = common.at_values(args, whole)
    part = part_of(args.table, whole, table)
    found = transition(table, of.ratio)
    laws, reasons = power_laws(found), left_out(table, of.ratio, above=0)
    numbers = beside_laws(found, laws).assign(of=of.ratio)
    hidden = hidden_text(found, "transition")
    words = (*part.values(), without_text(reasons), hidden, told_of(args.table, table))
    told = " ".join(filter(None, words))
    N, skipped = table["N"], skipped_text(found, "transition")
    write(out, transition_figure(found, look, told, of, (N.min(), N.max())), numbers, look)
    return [
        *taken,
        *report.rows_lines(table, report.used_of_lines(found, reasons), part),
        f"lines     {len(found)}, {found['N_transition'].notna().sum()} with a transition{report.lines_without(found)}",
        *report.part_lines({"skipped": skipped, "hidden": hidden}),
        *law_lines(laws, of, beside=is_papers(args.table, table)),
        *common.paths(args.table, out),
    ]


def law_lines(laws: pd.DataFrame, of: Quantity, beside: bool) -> list[str]:
    """The lines to print: each law's exponent; `beside` it the paper's, which is of the paper's own chain."""
    lines = []
    for law in laws.to_dict("records"):
        M, V = law["M_over_M0"], law["V_over_V0"]
        paper = EXPONENTS.get((M, V)) if beside and of == KE and law["definition"] == "log_slope" else None
        papers = f"; the paper {paper}" if paper else ""
        how = f"{law['points']} points, by the {DEFINITIONS[law['definition']].told(of)}{papers}"
        b, low, high = (exponent(law[name]) for name in ("b", "b_low", "b_high"))
        impact = f"({M:.4g}, {V:.4g})"
        lines.append(f"b         {b} ({low} to {high}) at {impact}, {how}")
    return lines or ["b         no impact has the four transitions that a power law needs"]
