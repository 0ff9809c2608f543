"""A figure of the paper as a function: tables and scenes in, a picture and its numbers out."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from analysis.paper.scenes import Seen, read_scenes, simulate_all
from analysis.table import load

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass
class Source:
    """Where tables and scene files lie. Each is read once, and each scene is run once."""

    tables: Path  # a folder with fig1.h5, fig4.h5, ..
    jobs: Path = Path("jobs/paper")  # its folder scenes/ holds fig2.toml, ..
    _tables: dict[str, pd.DataFrame] = field(default_factory=dict)
    _scenes: dict[str, list[Seen]] = field(default_factory=dict)

    def path(self, name: str) -> Path:
        """The table's file."""
        return self.tables / f"{name}.h5"

    def table(self, name: str) -> pd.DataFrame:
        """All finished rows; InputError where there are none."""
        if name not in self._tables:
            self._tables[name] = load(self.path(name))
        return self._tables[name]

    def scenes(self, name: str) -> list[Seen]:
        """All scenes of one file, simulated."""
        if name not in self._scenes:
            self._scenes[name] = simulate_all(read_scenes(self.jobs / "scenes" / f"{name}.toml"))
        return self._scenes[name]


@dataclass(frozen=True)
class Drawn:
    """A picture, what it plots, and what a reader must know about the rows behind it."""

    figure: "Figure"
    numbers: pd.DataFrame
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Recipe:
    """One figure of the paper."""

    number: str
    title: str
    caption: str  # in our words, for the page; plain text
    draw: Callable[[Source], Drawn]

    @cached_property
    def stem(self) -> str:
        """The name of its files, without the ending."""
        return f"fig{self.number}"

    @cached_property
    def alt(self) -> str:
        """A description for those who do not see the picture."""
        return f"Figure {self.number} of the paper from our own data: {self.title}"
