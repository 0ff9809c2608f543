"""The five findings judged on the tables of the figures that the paper supports them with."""

from typing import Any

from analysis.paper.figures import fig11
from analysis.paper.findings import impacts, threshold, viscosity, waves, worse
from analysis.paper.recipe import Source
from sweep.errors import InputError

# By the paper's own references: figure 1d shows the first three, figures 4 and 8 the first, 6 the second, 5 the third
# and (as figure 13) the fifth, 11 the fourth.
ANSWERS: tuple[tuple[Any, Any, tuple[str, ...]], ...] = (
    (viscosity, viscosity.lower_viscosity, ("fig1", "fig4", "fig4-mass", "fig8")),
    (threshold, threshold.sharp_threshold, ("fig1", "fig4", "fig6b")),
    (worse, worse.worse_than_linear, ("fig1", "fig5")),
    (waves, waves.solitary_waves, ("fig11",)),
    (impacts, impacts.wide_range, ("fig5", "fig8")),
)
NAMES = {"fig4-mass": "figure 4, M/M0 over 2.75", "fig6b": "figure 6b", "fig5": "figures 5 and 13"}


def answers(source: Source) -> list[dict[str, Any]]:
    """Each finding's `number`, `claim`, `rule`, and `answers`, one per table: `where`, `verdict`, `text`, `lacks`."""
    return [
        {
            "number": number,
            "claim": part.CLAIM,
            "rule": part.RULE,
            "answers": [_answer(source, holds, name) for name in names],
        }
        for number, (part, holds, names) in enumerate(ANSWERS, 1)
    ]


def _answer(source: Source, holds: Any, name: str) -> dict[str, str]:
    where = NAMES.get(name, f"figure {name.removeprefix('fig')}")
    try:
        finding = holds(fig11.profiles(source) if name == "fig11" else source.table(name))
    except InputError as error:
        return {"where": where, "verdict": "cannot tell", "text": "", "lacks": str(error)}
    lacks = finding.why if finding.holds is None else ""
    return {"where": where, "verdict": finding.verdict, "text": finding.text, "lacks": lacks}
