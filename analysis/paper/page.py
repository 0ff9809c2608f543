"""Draw every figure, compare every number, and fill the template."""

import base64
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analysis.look import MARK, settings
from analysis.output import output, write
from analysis.paper import answers, convention, sweeps
from analysis.paper.compare import compare, tally
from analysis.paper.draw_convention import convention_figure
from analysis.paper.figures import ALL
from analysis.paper.numbers import POINTS, Point
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.template import template
from sweep.errors import InputError

NAME = "paper"  # of the command, in the names of the files with the numbers


def lacks(source: Source) -> str:
    """Which folder there must be besides that of the tables, in words; empty where it is there."""
    scenes = source.jobs / "scenes"
    return "" if scenes.is_dir() else f"there is no directory {scenes} with scene files"


def pictures(folder: Path) -> list[Path]:
    """All that `build` may write, each with its numbers beside it."""
    return [folder / f"{stem}.png" for stem in [*(recipe.stem for recipe in ALL), "convention"]]


@dataclass(frozen=True)
class Page:
    """The page's text, and the lines that the command prints."""

    html: str
    lines: list[str]


def build(
    source: Source,
    folder: Path,
    recipes: Sequence[Recipe] = ALL,
    points: Sequence[Point] = POINTS,
    progress: Callable[[str], None] = lambda _: None,
) -> Page:
    """Make the page; pictures and their CSV go into `folder`, in place of what was there.

    A figure that lacks its table is named as left out.
    """
    sections, left_out = [], []
    for recipe in recipes:
        progress(f"figure {recipe.number}")
        try:
            with settings():
                drawn = recipe.draw(source)
        except InputError as error:
            left_out.append({"number": recipe.number, "why": str(error)})
            continue
        sections.append(_section(recipe, drawn, folder))
    progress("numbers")
    numbers = compare(source, points)
    progress("findings")
    found = answers.answers(source)
    progress("conventions")
    scanned = convention.scan(tuple(points))
    write(output(folder / "convention.png", NAME, force=True), convention_figure(scanned), scanned)
    html = template("analysis.paper").render(
        mark=MARK,
        sections=sections,
        left_out=left_out,
        numbers=numbers.to_dict("records"),
        verdicts=tally(numbers["verdict"]),
        findings=found,
        sweeps=[sweeps.history(path) for path in sorted(source.tables.glob("*.h5"))],
        conventions=convention.summary(scanned).to_dict("records"),
        named=convention.named(tuple(points)).to_dict("records"),
        convention_picture=inline(folder / "convention.png"),
    )
    lines = [
        f"figures   {len(sections)} drawn, {len(left_out)} left out",
        f"numbers   {len(numbers)}: {tally(numbers['verdict'])}",
        f"findings  {len(found)}, on their tables: "
        + tally(one["verdict"] for finding in found for one in finding["answers"]),
    ]
    return Page(html, lines + [f"left out  figure {one['number']}: {one['why']}" for one in left_out])


def _section(recipe: Recipe, drawn: Drawn, folder: Path) -> dict[str, Any]:
    out = output(folder / f"{recipe.stem}.png", NAME, force=True)
    write(out, drawn.figure, drawn.numbers)
    return {"recipe": recipe, "picture": inline(out.picture), "notes": drawn.notes, "rows": len(drawn.numbers)}


def inline(picture: Path) -> dict[str, Any]:
    """A PNG as text for the page, and its size there: two of its pixels are one of the page."""
    data = picture.read_bytes()
    width, height = (side // 2 for side in struct.unpack(">II", data[16:24]))
    return {"data": base64.b64encode(data).decode(), "width": width, "height": height}
