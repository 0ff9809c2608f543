"""Question d: have chains that are not bistable a threshold in N?"""

from typing import Any

import pandas as pd

from analysis import style
from analysis.colours import log_bar, shades
from analysis.outlook.draws import share_of
from analysis.outlook.part import Grid, Part, Picture, Question, interval
from analysis.paper.recipe import Source
from analysis.table import IMPACT
from analysis.transition import transition
from sweep.plan.fall import HIGH, LOW

LATTICES = {  # by the name of their table
    "bistable": "the paper's, bistable",
    "granular": "grains under precompression, Hertz's law",
    "fput": "Fermi, Pasta, Ulam and Tsingou's, stiffening",
    "toda": "Toda's",
    "softening": "softening, straight pieces, no second well",
}
YES = 0.5  # of the lines
RULE = (
    "of `analysis transition`: a line, one impact at one zeta_T, has a transition where ke_ratio begins above "
    f"{HIGH:g} and ends below {LOW:g} at the largest N; a chain has a threshold where at least {YES:.0%} of its lines "
    "have one, none where no line has"
)
SHOWN = (2.0, 2.0)  # the impact that is drawn


def answer(df: pd.DataFrame) -> dict[str, Any]:
    """Of one chain: `lines`, `transitions`, the interval of their share (Wilson, 95 %), `others`, and the `verdict`."""
    found = transition(df)
    with_one = int((found["why_not"] == "").sum())
    share, low, high = share_of(with_one, len(found))
    others = found["why_not"][found["why_not"] != ""].value_counts()
    verdict = "yes" if share >= YES else "some lines" if with_one else "no"
    told = {"lines": len(found), "transitions": with_one, "low": low, "high": high, "verdict": verdict}
    without = ", ".join(f"{count} {why}" for why, count in others.items())
    return told | {"chaotic": int(found["chaotic"].sum()), "others": without}


def part(source: Source) -> Part:
    """From a table per chain."""
    found = {name: answer(source.table(name)) for name in LATTICES}
    rows = [
        [
            LATTICES[name],
            f"{told['transitions']} of {told['lines']}",
            interval(told["transitions"] / told["lines"], told["low"], told["high"], ".2f"),
            told["others"] or "–",
            str(told["chaotic"]),
            told["verdict"],
        ]
        for name, told in found.items()
    ]
    columns = ("chain", "lines with a transition", "share (95 %)", "the others", "chaotic rows left out", "threshold")
    yes = [LATTICES[name] for name, told in found.items() if told["verdict"] == "yes"]
    no = [LATTICES[name] for name, told in found.items() if told["verdict"] == "no"]
    sentences = [
        f"Yes: {'; '.join(yes) or 'none'}. No: {'; '.join(no) or 'none'}.",
        "Each chain was asked at one set of its numbers: an answer for these chains, not for all of their kind. Cubic "
        "chains without a second stable state are under question a: some have the threshold.",
    ]
    picture = Picture("d-lattices", *_draw(source), CAPTION, "KE ratio against N for five chains")
    return Part(sentences, [picture], [Grid("By the same rule", columns, rows)])


def _draw(source: Source) -> tuple[Any, pd.DataFrame]:
    figure, axes = style.canvas(1, len(LATTICES), 11.0, 2.9, sharex=True, sharey=True)
    tables = [_impact(source.table(name)).assign(chain=name) for name in LATTICES]
    numbers = pd.concat(tables)
    scale = shades(numbers.loc[numbers["zeta_T"] > 0, "zeta_T"])
    for ax, name, rows in zip(axes[0], LATTICES, tables, strict=True):
        for zeta_T, line in rows.groupby("zeta_T"):
            style.curve(ax, line, "N", "ke_ratio", scale.to_rgba(float(zeta_T)), "")  # type: ignore[arg-type]
        style.against_one(ax, "$N$")
        ax.set_title(name, fontsize=9)
    for ax in axes[0, 1:]:
        ax.set_ylabel("")
    style.plain_ticks(axes[0, 0].yaxis)
    log_bar(figure, scale, style.LABELS["zeta_T"], ax=list(axes[0]))
    return figure, numbers


def _impact(df: pd.DataFrame) -> pd.DataFrame:
    """The rows of the impact that is drawn, or of the first there is."""
    for impact in (SHOWN, df[IMPACT].to_numpy(float)[0]):
        rows: pd.DataFrame = df[(df[IMPACT].to_numpy(float) == impact).all(axis=1)]
        if len(rows):
            break
    return rows


CAPTION = (
    "KE ratio against N for the five chains at M/M0 = 2, V/V0 = 2, coloured by zeta_T; open circles are chaotic; the "
    "thin line is where nonlinear and linear chain do the same."
)
QUESTION = Question(
    "d",
    "Other lattices",
    "Is the threshold in N a matter of bistability, or of any nonlinear lattice?",
    (RULE,),
    tuple(LATTICES),
    ("d-lattices",),
    part,
)
