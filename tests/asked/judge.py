"""What every answer is judged by: a command with what its refusal must say, and how its lines and its CSV are read."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from PIL import Image

from tests.asked.told import Told, must

Judge = Callable[[Told, pd.DataFrame], None]


@dataclass(frozen=True)
class Question:
    """The words of a command; the words one of which its refusal must hold, where it is to be refused; its judge."""

    arguments: list[str]
    refused: list[str]
    judge: Judge
    picture: str = ""
    pixels: tuple[int, int] | None = None


def judge(asked: Question, told: Told, folder: Path, program: str = "analysis") -> None:
    """The rules that hold for every answer, then its own."""
    must(told.status in (0, 2), f"{told.line}: exit status {told.status}\n{told.err}")
    if asked.refused or told.status:
        lines, refused = told.err.splitlines(), list(asked.refused)
        refused += ["inches are too small for this picture"] if asked.pixels else []
        must(told.status == 2, f"{told.line}: is not refused ({asked.refused})\n{told.out}")
        must(not told.wrote, f"{told.line}: refused, has written {set(told.wrote)}")
        must(any(word in told.err for word in refused), f"{told.line}: refused, {told.err}")
        must(all(line.startswith(f"{program}: ") for line in lines) and not told.out, f"{told.line}: {told}")
        return
    must(not told.err, f"{told.line}: complains: {told.err}")
    numbers = f"{asked.picture.rpartition('.')[0]}.{told.line.split()[1]}.csv"
    must(told.wrote == {asked.picture, numbers}, f"{told.line}: has written {set(told.wrote)}")
    _whole(folder / asked.picture, asked.pixels, told)
    asked.judge(told, pd.read_csv(folder / numbers, float_precision="round_trip"))


def _whole(picture: Path, pixels: tuple[int, int] | None, told: Told) -> None:
    """It can be read, and has the size that was asked for."""
    if picture.suffix == ".png":
        with Image.open(picture) as image:
            image.load()
            must(pixels in (None, image.size), f"{told.line}: {image.size} pixels, asked for {pixels}")
    elif picture.suffix == ".svg":
        ET.parse(picture)
    else:
        must(picture.read_bytes().rstrip().endswith(b"%%EOF"), f"{told.line}: no whole .pdf")


def said(told: Told, pattern: str) -> "re.Match[str]":
    """The line of the answer that reads so."""
    found = re.search(pattern, told.out, re.MULTILINE)
    must(found, f"{told.line}: no line {pattern!r} in\n{told.out}")
    assert found
    return found


def rows_line(told: Told, rows: pd.DataFrame, what: str = "") -> None:
    """The line that counts the rows by status."""
    counts = rows["status"].value_counts()
    line = said(told, rf"^rows +(\d+){what}: (.*)$")
    parts = dict(reversed(part.split(" ", 1)) for part in line[2].split(", "))
    must(int(line[1]) == len(rows), f"{told.line}: {line[0]}, of {len(rows)}")
    must({name: int(n) for name, n in parts.items()} == counts.to_dict(), f"{told.line}: {line[0]}, {counts}")


def same(told: Told, csv: pd.DataFrame, rows: pd.DataFrame, but: tuple[str, ...] = ()) -> None:
    """The CSV has these rows in this order, with their numbers."""
    must(
        csv["task"].tolist() == rows.index.tolist(), f"{told.line}: rows {csv['task'].tolist()}, not {list(rows.index)}"
    )
    for name in csv:
        if name == "task" or name in but:
            continue
        ours = rows[name].where(rows["checked"]) if name == "chaotic" else rows[name]
        theirs = csv[name].astype(object)
        must(alike(theirs, ours), f"{told.line}: {name} is {theirs.tolist()}, not {ours.tolist()}")


def alike(theirs: Iterable[object], ours: Iterable[object]) -> bool:
    """Whether two columns are equal, what is missing included."""
    pairs = zip(theirs, ours, strict=True)
    return all(pd.isna(a) and pd.isna(b) if pd.isna(a) or pd.isna(b) else a == b for a, b in pairs)


def is_told(a: str, b: float, digits: int = 4) -> bool:
    """Whether a printed number is this one."""
    return a == f"{b:.{digits}g}"


def lowest(told: Told, cells: pd.DataFrame, of: str, chaotic_too: bool = False) -> None:
    """The line on the lowest of what is drawn, and the one on chaotic ones below it."""
    firm = cells[~cells["chaotic"]]
    some = cells if chaotic_too or firm.empty else firm
    line = said(told, rf"^lowest +{of} = (\S+) \((.*)\) at N = (\d+), ")
    must(is_told(line[1], some[of].min()), f"{told.line}: {line[0]}, not {some[of].min()}")
    top = some[some[of] == some[of].min()]
    must(int(line[3]) in top["N"].tolist(), f"{told.line}: {line[0]}, not N = {top['N'].tolist()}")
    lower = cells[cells["chaotic"] & (cells[of] < some[of].min())]
    if len(lower) and not top["chaotic"].all():
        words = said(told, r"^chaotic +(\d+) (?:cells?|points?) (?:is|are) lower, down to \S+ = (\S+) ")
        must(int(words[1]) == len(lower) and is_told(words[2], lower[of].min()), f"{told.line}: {words[0]}, {lower}")


def never(told: Told, _csv: pd.DataFrame) -> None:
    """Of a command that is to be refused: its answer is wrong, whatever it is."""
    must(False, f"{told.line}: was to be refused")
