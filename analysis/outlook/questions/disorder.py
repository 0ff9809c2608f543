"""Question e: how much disorder the optimum of figure 8 survives."""

from typing import Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.look import COLOURS
from analysis.outlook.disorder import CELL, KINDS, RULE, SURVIVES, losses, survival
from analysis.outlook.part import Grid, Part, Picture, Question, interval
from analysis.paper.recipe import Source


def part(source: Source) -> Part:
    """From the table disorder."""
    lost = losses(source.table("disorder"))
    total, cells = survival(lost), survival(lost, tuple(CELL))
    picture = Picture(
        "e-disorder", _draw(total, cells), lost[COLUMNS], CAPTION, "Loss against the spread of the disorder"
    )
    calm = int(lost["loss"].notna().sum())
    missing = [
        f"{len(lost)} draws of {lost[CELL].drop_duplicates().shape[0]} optima; {len(lost) - calm} chaotic, or of a "
        "chaotic uniform chain, and left out",
        "the impact stays the one that is best for the uniform chain; it is not looked for anew",
    ]
    return Part(_answer(total, cells), [picture], [_totals(total), _cells(cells)], missing)


COLUMNS = [*CELL, "kind", "spread", "loss", "loss_ke", "ke_ratio", "uniform"]


def _answer(total: pd.DataFrame, cells: pd.DataFrame) -> list[str]:
    both = total[total["kind"] == "both"]
    told = [
        f"{100 * one['spread']:.0f} %: {interval(one['median'], one['low'], one['high'])} times, {one['verdict']}"
        for one in both.to_dict("records")
    ]
    worst = total.sort_values("worst").to_dict("records")[-1]
    some = cells[cells["kind"] == "both"]
    each = [
        f"{100 * spread:.0f} %: {((some['spread'] == spread) & (some['verdict'] == 'survives')).sum()} of "
        f"{(some['spread'] == spread).sum()}"
        for spread in np.unique(some["spread"].to_numpy(float))
    ]
    return [
        f"With masses and stiffnesses both spread, median of all optima: {'; '.join(told)}.",
        f"Optima that survive, each by itself: {'; '.join(each)}.",
        f"The worst draw of all passes on {worst['worst']:.3g} times as much ({worst['kind']}, "
        f"{100 * worst['spread']:.0f} %).",
    ]


def _totals(total: pd.DataFrame) -> Grid:
    columns = ("disorder in", "spread", "calm draws", "median loss (95 %)", "worst", f"share below {SURVIVES:g}")
    rows = [
        [
            str(one["kind"]),
            f"{100 * one['spread']:.0f} %",
            f"{one['calm']} of {one['draws']}",
            interval(one["median"], one["low"], one["high"]),
            f"{one['worst']:.3g}",
            interval(one["below"], one["below_low"], one["below_high"], ".2f"),
            f"{one['median_ke']:.3g}",
            f"{one['median_all']:.3g}",
            str(one["verdict"]),
        ]
        for one in total.to_dict("records")
    ]
    return Grid("All optima together", (*columns, "of the peak itself", "chaotic draws too", "verdict"), rows)


def _cells(cells: pd.DataFrame) -> Grid:
    some = cells[cells["kind"] == "both"]
    spreads = sorted(some["spread"].unique())
    rows = []
    for key, group in some.groupby(CELL):
        N, zeta_T, M, V = key
        by_spread = group.set_index("spread")
        told = [
            f"{interval(*by_spread.loc[spread, ['median', 'low', 'high']])}: {by_spread.loc[spread, 'verdict']}; "
            f"{by_spread.loc[spread, 'calm']} calm"
            for spread in spreads
        ]
        rows.append([f"N = {N:g}, zeta_T = {zeta_T:.3g}", f"({M:.3g}, {V:.3g})", *told])
    columns = ("optimum", "(M/M0, V/V0)", *(f"{100 * spread:.0f} % in both" for spread in spreads))
    return Grid("Every optimum by itself: median loss", columns, rows)


def _draw(total: pd.DataFrame, cells: pd.DataFrame) -> Any:
    figure, axes = style.canvas(1, 3, 9.6, 3.4, sharey=True, sharex=True)
    N = sorted(cells["N"].unique())
    for ax, kind in zip(axes[0], KINDS, strict=True):
        for key, rows in cells[cells["kind"] == kind].groupby(CELL):
            colour = COLOURS[2 + N.index(key[0]) % 5]
            ax.plot(
                100 * rows["spread"],
                rows["median"],
                "-",
                color=colour,
                linewidth=0.8,
                label=f"$N$ = {key[0]:g}, an optimum",
            )
        one = total[total["kind"] == kind]
        bars = np.abs(one[["low", "high"]].to_numpy(float).T - one["median"].to_numpy(float))
        ax.errorbar(
            100 * one["spread"], one["median"], bars, fmt="o", color="black", ms=4, capsize=2, label="all, with 95 %"
        )
        ax.plot(100 * one["spread"], one["worst"], "v", color=COLOURS[1], ms=4, label="worst draw")
        ax.axhline(SURVIVES, color="0.5", linewidth=0.8, linestyle="--")
        ax.axhline(1, color="0.7", linewidth=0.6)
        ax.set(yscale="log", xlabel="spread in %", xticks=sorted(100 * total["spread"].unique()))
        style.plain_ticks(ax.yaxis)
    axes[0, 0].set_ylabel("loss: KE ratio over that of the uniform chain")
    axes[0, 0].yaxis.label.set_fontsize(8)
    style.letter(axes, ["masses", "stiffnesses", "both"])
    style.legend(figure, axes)
    return figure


CAPTION = (
    "What disorder costs: KE ratio over that of the uniform chain, medians over the draws, for disorder in the masses, "
    "in the stiffnesses, in both. A line is one optimum (N, zeta_T) of figure 8, black dots are all of them together, "
    "triangles the worst draw; above the dashed line the optimum has not survived."
)
QUESTION = Question(
    "e",
    "Disorder",
    "How much disorder, 5, 10 or 20 % in stiffness and mass, does the optimum of figure 8 survive?",
    (RULE,),
    ("disorder",),
    ("e-disorder",),
    part,
)
