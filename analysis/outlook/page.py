"""Answer every question, write its pictures, and fill the template."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from analysis.look import MARK, settings
from analysis.outlook.part import Part, Question
from analysis.outlook.questions import ALL
from analysis.output import output, write
from analysis.paper import sweeps
from analysis.paper.page import Page, inline
from analysis.paper.recipe import Source
from analysis.template import template
from sweep.errors import InputError

NAME = "outlook"  # of the command, in the names of the files with the numbers


def pictures(folder: Path) -> list[Path]:
    """All that `build` may write, each with its numbers beside it."""
    return [folder / f"{stem}.png" for question in ALL for stem in question.stems]


def lacks(source: Source) -> str:
    """Which tables of the questions are not there, in words; empty where all are."""
    names = dict.fromkeys(name for question in ALL for name in question.tables)
    missing = [f"{name}.h5" for name in names if not source.path(name).is_file()]
    return f"{source.tables} lacks {', '.join(missing)}; `make outlook` makes them" if missing else ""


def build(
    source: Source,
    folder: Path,
    questions: Sequence[Question] = ALL,
    progress: Callable[[str], None] = lambda _: None,
) -> Page:
    """Make the page; pictures and their CSV go into `folder`, in place of what was there.

    A question that its tables cannot answer is left out, and the page says why.
    """
    sections = []
    for question in questions:
        progress(f"question {question.letter}")
        sections.append(_section(question, source, folder))
    paths = sorted({source.path(name) for question in questions for name in question.tables})
    html = template("analysis.outlook", "analysis.paper").render(
        mark=MARK, sections=sections, sweeps=[sweeps.history(path) for path in paths if path.is_file()]
    )
    return Page(html, [_line(one) for one in sections])


def _section(question: Question, source: Source, folder: Path) -> dict[str, Any]:
    try:
        with settings():
            part = question.part(source)
    except InputError as error:
        return {"question": question, "part": None, "pictures": [], "why": str(error)}
    return {"question": question, "part": part, "pictures": _written(part, folder), "why": ""}


def _written(part: Part, folder: Path) -> list[dict[str, Any]]:
    found = []
    for one in part.pictures:
        out = output(folder / f"{one.stem}.png", NAME, force=True)
        write(out, one.figure, one.numbers)
        texts = {"stem": one.stem, "caption": one.caption, "alt": one.alt}
        found.append({"inline": inline(out.picture), "rows": len(one.numbers), **texts})
    return found


def _line(section: dict[str, Any]) -> str:
    part, letter = section["part"], section["question"].letter
    return f"{letter}         {part.answer[0] if part else 'left out: ' + section['why']}"
