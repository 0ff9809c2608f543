"""What a question puts on the page: its rule, its answer, pictures and tables."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from analysis.paper.recipe import Source

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Picture:
    """A picture, the numbers that it shows, and what to say of it."""

    stem: str
    figure: "Figure"
    numbers: pd.DataFrame
    caption: str
    alt: str


@dataclass(frozen=True)
class Grid:
    """A table of the page: texts, the first of each row its heading."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Part:
    """What a question came to. `answer` in sentences, the first of them the one to remember."""

    answer: Sequence[str]
    pictures: Sequence[Picture] = ()
    tables: Sequence[Grid] = ()
    not_computed: Sequence[str] = ()


@dataclass(frozen=True)
class Question:
    """One of the questions: its tables, and how it is answered from them."""

    letter: str
    title: str
    asks: str
    rules: Sequence[str]
    tables: Sequence[str]  # names of the tables in the folder
    stems: Sequence[str]  # of its pictures
    part: Callable[[Source], Part]


def interval(value: float, low: float, high: float, form: str = ".3g") -> str:
    """For example "0.51 (0.49 to 0.53)"; a dash where nothing is known."""
    return f"{value:{form}} ({low:{form}} to {high:{form}})" if value == value else "–"
