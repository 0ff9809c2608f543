"""Question c: the findings by other figures of merit."""

from typing import Any

import pandas as pd

from analysis import style
from analysis.look import COLOURS
from analysis.outlook.merits import MERITS, RULE, Merit, chosen, held, misled, pairs
from analysis.outlook.part import Grid, Part, Picture, Question, interval
from analysis.paper.findings.finding import Finding
from analysis.paper.findings.impacts import RULE as IMPACTS
from analysis.paper.findings.threshold import RULE as THRESHOLD
from analysis.paper.findings.viscosity import RULE as VISCOSITY
from analysis.paper.findings.worse import RULE as WORSE
from analysis.paper.recipe import Source

SHORT = {"wall_force": "wall force", "ke": "kinetic energy", "dissipated": "dissipated share"}


def part(source: Source) -> Part:
    """From the table merit."""
    df = source.table("merit")
    found, away = held(df), misled(df)
    numbers = pd.concat([pairs(df, one).assign(of=one.name) for one in MERITS[1:]])
    picture = Picture("c-merits", _draw(df, away), numbers, CAPTION, "Four figures of merit against the KE ratio")
    counts = next(iter(found.values()))[0].numbers
    missing = [
        "finding 4 is about the waves, not about a figure of merit: it is judged on the page of `make paper` alone",
        f"{counts['rows']} rows used; {counts.get('chaotic, left out', 0)} chaotic and left out, by the flag of "
        "ke_ratio",
        "without damping nothing is dissipated: no ratio, and finding 3 cannot be told by the dissipated share",
    ]
    return Part(_answer(found, away), [picture], [_verdicts(found), _misled(away)], missing)


def _answer(found: dict[str, list[Finding]], away: pd.DataFrame) -> list[str]:
    told = []
    for merit in MERITS[1:]:
        words = [f"{one.number} {one.verdict}" for one in found[merit.name]]
        told.append(f"by {_short(merit)}: {', '.join(words)}")
    wrong = away[away["verdict"] == "misleads"]
    names = [SHORT.get(name, name) for name in wrong["name"]]
    worst = away.sort_values("share").to_dict("records")[-1]
    mislead = (
        f"ke_ratio misleads about {' and '.join(names)}"
        if names
        else "ke_ratio misleads about none of the four, by the rule"
    )
    share = interval(100 * worst["share"], 100 * worst["low"], 100 * worst["high"], ".0f")
    orders = ", ".join(f"{SHORT.get(one['name'], one['name'])} {one['rank']:.2f}" for one in away.to_dict("records"))
    return [
        f"Findings {'; '.join(told)}.",
        f"{mislead}. The most wrong: the chain that it chooses is worse than the linear one by "
        f"{SHORT.get(worst['name'], worst['name'])} at {worst['worse']} of {worst['impacts']} impacts, {share} %.",
        f"Does ke_ratio order chains as the figure does? Rank correlations: {orders}.",
    ]


def _short(merit: Merit) -> str:
    return SHORT.get(merit.name, merit.name)


def _verdicts(found: dict[str, list[Finding]]) -> Grid:
    first = found[MERITS[0].name]
    rows = []
    for place, finding in enumerate(first):
        cells = [_cell(found[merit.name][place]) for merit in MERITS]
        rows.append([f"{finding.number}. {finding.claim}", *cells])
    return Grid("The findings by every figure", ("finding", *(_short(merit) for merit in MERITS)), rows)


def _cell(finding: Finding) -> str:
    """The verdict, and the first number that speaks for it."""
    keys = {1: "pairs in order", 2: "sharp", 3: "impacts that lose, coarse", 5: "least share of impacts won, fine"}
    value = finding.numbers.get(keys[finding.number])
    if value is None:
        return f"{finding.verdict} ({finding.why})" if finding.holds is None else finding.verdict
    text = f"{value:.2f}" if isinstance(value, float) else str(value)
    lacks = f"; {finding.why}" if finding.holds is None else ""
    return f"{finding.verdict} ({keys[finding.number]}: {text}{lacks})"


def _misled(away: pd.DataFrame) -> Grid:
    columns = ("figure", "rank correlation with ke_ratio", "chosen chain worse than linear")
    rows = [
        [
            str(one["words"]),
            interval(one["rank"], one["rank_low"], one["rank_high"], ".2f"),
            f"{one['worse']} of {one['impacts']}: {interval(one['share'], one['low'], one['high'], '.2f')}",
            f"{one['price']:.3g}",
            str(one["verdict"]),
        ]
        for one in away.to_dict("records")
    ]
    return Grid("Whoever chooses a chain by ke_ratio", (*columns, "times the least it could be", "verdict"), rows)


def _draw(df: pd.DataFrame, away: pd.DataFrame) -> Any:
    figure, axes = style.canvas(1, 4, 11.0, 3.3, sharex=True)
    for ax, merit in zip(axes[0], MERITS[1:], strict=True):
        rows = pairs(df, merit)
        ax.plot(rows["ke_ratio"], rows["figure"], ".", color="0.65", markersize=2, label="a chain under an impact")
        won = chosen(rows)
        text = "the chain of the lowest KE ratio, for every impact"
        ax.plot(won["ke_ratio"], won["figure"], "o", color=COLOURS[1], markersize=3.5, mew=0, label=text)
        ax.axhline(1, color="0.3", linewidth=0.7)
        ax.axvline(1, color="0.3", linewidth=0.7)
        ax.set(xscale="log", yscale="log", xlabel="KE ratio", ylabel=f"{_short(merit)} ratio")
    style.letter(axes, [f"rank {one:.2f}" for one in away["rank"]])
    style.legend(figure, axes)
    return figure


CAPTION = (
    "Four figures of merit over those of the linear chain against the KE ratio, a dot per chain and impact that is not "
    "chaotic; below the horizontal line the bistable chain is the better one by that figure. Orange: for every impact "
    "the chain with the lowest KE ratio; where it is above the line, whoever chose it by the KE ratio was misled. The "
    "dissipated share stands upside down (linear over bistable), so that below 1 is better there too."
)
QUESTION = Question(
    "c",
    "Other figures of merit",
    "Do the five findings hold for the force on the wall, the acceleration, the impulse and the dissipated share? By "
    "which of them would a designer be misled who looked at the kinetic energy alone?",
    (
        "the rules of `analysis findings`, with the ratio of that figure in place of ke_ratio; of the dissipated "
        "share, of which more is better, the inverse ratio",
        *(f"finding {number}: {text}" for number, text in ((1, VISCOSITY), (2, THRESHOLD), (3, WORSE), (5, IMPACTS))),
        RULE,
    ),
    ("merit",),
    ("c-merits",),
    part,
)
