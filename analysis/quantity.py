"""A quantity that is compared between a chain and the same made linear: its columns, and its name on pictures.

Every quantity q of a table has a column q_ratio, its value over that in the linear chain. Functions
that show or compare a ratio ask a Quantity which columns to read; by default that of KE.
"""

from dataclasses import dataclass

from analysis.errors import InputError

_ENDING = "_ratio"


@dataclass(frozen=True)
class Quantity:
    """`name` as a spec's `observe` has it; `title` stands beside a scale, `meaning` below a picture."""

    name: str
    title: str
    meaning: str

    @property
    def ratio(self) -> str:
        """The column of the ratio."""
        return self.name + _ENDING

    @property
    def error(self) -> str:
        """The column of the ratio's estimated relative error; that of the kinetic energy is the table's oldest."""
        return "error" if self.name == "ke" else f"{self.name}_error"

    @property
    def spread(self) -> tuple[str, ...]:
        """The columns of the range of a chaotic row's ratio, which tables hold for the kinetic energy only."""
        return ("spread_low", "spread_high") if self.name == "ke" else ()


KE = Quantity(
    "ke",
    "KE ratio",
    "KE ratio: largest kinetic energy of the site that is watched (the middle one, unless the model names another), "
    "over that in the same chain made linear; below 1 it protects better.",
)


def quantity(column: str) -> Quantity:
    """The quantity whose ratio is in this column; InputError for a name that is none of a ratio."""
    name = column.removesuffix(_ENDING)
    if not column.endswith(_ENDING) or not name:
        raise InputError(
            f"--of {column}: is no ratio of two chains, which is what a map compares: ke_ratio, and q_ratio of every "
            f"other quantity q that the spec observes, such as {name}_ratio; `analysis page` shows any column"
        )
    words = name.replace("_", " ")
    meaning = f"{words} ratio: {words} over that of the same chain made linear."
    return KE if name == KE.name else Quantity(name, f"{words} ratio", meaning)
