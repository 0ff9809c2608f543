"""The picture of what each part of certification costs and catches, of what `python -m tests.parts --keep` has kept."""

from pathlib import Path
from typing import TYPE_CHECKING

from analysis.look import settings
from tests import measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Columns of the kept table: runs that cost, in the order in which they are made, and what they catch.
COSTS = ("first run, tighter where the target is 1e-1 or 1e-2", "companion", "third run", "disturbed runs")
COSTS += ("spreads, refinements",)
CAUGHT = ("misses of the first run: told by looser runs, of all", "chaotic ones flagged")
# Of Okabe and Ito, apart in every kind of colour vision; hatches tell the same in grey.
COLOURS = ("#0072B2", "#56B4E9", "#009E73", "#E69F00", "#CC79A7")
HATCHES = ("", "//", "xx", "..", "\\\\")


def draw(path: Path) -> None:
    """Left what each part costs at each target, in plain runs; right the shares that are caught, with their numbers."""
    from matplotlib.figure import Figure

    rows = measured.kept("parts")["rows"]
    with settings():
        figure = Figure(figsize=(7.4, 3.4), layout="constrained")
        costs, caught = figure.subplots(1, 2, width_ratios=(3, 2))
        _costs(costs, rows)
        _caught(caught, rows)
        for ax, letter in zip((costs, caught), "ab", strict=True):
            ax.set_title(f"({letter})", loc="left")
            ax.set_xticks(range(len(rows)), [row["target"] for row in rows])
            ax.set_xlabel("target")
            ax.grid(axis="y", color="0.88", linewidth=0.5)
            ax.set_axisbelow(True)
            ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, fontsize=7, frameon=False)
        figure.savefig(path, dpi=200)


def _costs(ax: "Axes", rows: list[dict[str, str]]) -> None:
    below = [0.0] * len(rows)
    for name, colour, hatch in zip(COSTS, COLOURS, HATCHES, strict=True):
        heights = [float(row[name]) for row in rows]
        ax.bar(
            range(len(rows)), heights, 0.6, below, label=name.replace(COSTS[0], "first run"), color=colour, hatch=hatch
        )
        below = [low + height for low, height in zip(below, heights, strict=True)]
    ax.axhline(1.0, color="black", linewidth=0.8, linestyle="--", label="one run, not certified")
    ax.set_ylabel("time, in runs not certified")


def _caught(ax: "Axes", rows: list[dict[str, str]]) -> None:
    for k, (name, label) in enumerate(zip(CAUGHT, ("misses of the first run", "chaotic tasks"), strict=True)):
        numbers = [tuple(map(int, row[name].split(" of "))) for row in rows]
        places = [place + 0.4 * (k - 0.5) for place in range(len(rows))]
        shares = [100.0 * some / whole if whole else 0.0 for some, whole in numbers]
        bars = ax.bar(places, shares, 0.38, label=label, color=COLOURS[2 * k], hatch=HATCHES[2 * k])
        texts = [f"{some}/{whole}" for some, whole in numbers]
        ax.bar_label(bars, texts, rotation=90, padding=3, fontsize=6.5)
    ax.set(ylim=(0, 129), yticks=range(0, 101, 20), ylabel="caught (%)")
