"""A quantity that is compared between a chain and the same made linear: its columns, and its name on pictures.

Every quantity q of a table has a column q_ratio, its value q over q_linear, that in the linear chain. Functions
that show or compare a ratio ask a Quantity which columns to read; by default that of KE. What only shows numbers, as a
map, takes a value as well: of `flipped` there is no ratio, as no link of a linear chain flips.
"""

import re
from dataclasses import dataclass
from inspect import getdoc

from kernel import columns
from kernel.hints import shown
from sweep.errors import InputError
from sweep.schema import ROW

# Of the paper's chain, by their names in units; a unit of no such name is a word.
_UNIT_WORDS = {
    "k_T": "bulk stiffness of the chain",
    "m_T": "mass of the chain",
    "L": "length of the chain",
    "m_im": "mass of the impactor",
    "V": "its speed",
    "TE": "energy of the impact",
}
_ENDING, _LINEAR, _ERROR = "_ratio", "_linear", "_error"


@dataclass(frozen=True)
class Quantity:
    """`name` as a spec's `observe` has it; `title` stands beside a scale, `meaning` below a picture.

    `ending` is that of the column: none or "_linear" where it holds the value of one chain, which is no ratio.
    """

    name: str
    title: str
    meaning: str
    ending: str = _ENDING

    @property
    def ratio(self) -> str:
        """The column of the ratio; of a value that of the value."""
        return self.name + self.ending

    @property
    def is_ratio(self) -> bool:
        """Whether 1 stands for two chains that do the same."""
        return self.ending == _ENDING

    @property
    def error(self) -> str:
        """The column of the estimated relative error; that of the kinetic energy is the table's oldest."""
        return "error" if self.name == "ke" else self.name + _ERROR

    @property
    def spread(self) -> tuple[str, ...]:
        """The columns of the range of a chaotic row's ratio, which tables hold for the kinetic energy only."""
        return ("spread_low", "spread_high") if self.name == "ke" and self.is_ratio else ()

    @property
    def error_of(self) -> str:
        """The ratio that `error` is of, where it is not of this column: what is told of the kinetic energy is."""
        return KE.ratio if self.name == "ke" and not self.is_ratio else ""


KE = Quantity(
    "ke",
    "KE ratio",
    "KE ratio: largest kinetic energy of the site that is watched (the middle one, unless the model names another), "
    "over that in the same chain made linear; below 1 it protects better.",
)
_PEAK = (
    "Peak KE/TE: largest kinetic energy of the site that is watched (the middle one, unless the model names another), "
    "over TE, the total energy at the start"
)
ENERGIES = (
    Quantity("ke", "peak KE/TE", f"{_PEAK}.", "_bistable"),
    Quantity("ke", "peak KE/TE, made linear", f"{_PEAK}, in the chain made linear.", _LINEAR),
)
_ENERGIES = " or ".join(one.ratio for one in ENERGIES)
_RATIOS = f"{KE.ratio}, or q_ratio of another quantity q that the spec observes"


def quantity(column: str) -> Quantity:
    """The quantity whose ratio or value is in this column; InputError for a column that belongs to none."""
    ours = column in (columns.KE, columns.PEAK_KE, *(ROW.names or ())) and column != KE.ratio
    if not isinstance(column, str) or column == _ENDING or ours or column.endswith(_ERROR):
        raise InputError(
            f"of: must be {_RATIOS}, or q itself, or on a map or points {_ENERGIES}, got {shown(column)}; "
            "`analysis page` shows any column of a table"
        )
    if not column.endswith(_ENDING):
        return _value(column)
    name = column.removesuffix(_ENDING)
    words = name.replace("_", " ")
    meaning = f"{words} ratio: {words} over that of the same chain made linear."
    return KE if name == KE.name else Quantity(name, f"{words} ratio", meaning)


def shown_by(column: str) -> Quantity:
    """The same for what only shows numbers: of the kinetic energy, too, the value in either chain."""
    return next((one for one in ENERGIES if one.ratio == column), None) or quantity(column)


def ratio(column: str) -> Quantity:
    """The quantity whose ratio is in this column; InputError for a column that holds none."""
    found = quantity(column)
    if not found.is_ratio:
        raise InputError(f"of: must be the ratio of two chains, {_RATIOS}, got {shown(column)}")
    return found


def _value(column: str) -> Quantity:
    from kernel.quantities import QUANTITIES  # and with it the compiler, which the ratios do without
    from sweep.store.meanings import unit

    name, of = column.removesuffix(_LINEAR), unit(column)
    ending, words = column.removeprefix(name), column.replace("_", " ")
    if name not in QUANTITIES:
        return Quantity(name, words, f"{words}.", ending)
    what = (getdoc(type(QUANTITIES[name])) or words).partition("\n\n")[0].replace("\n", " ").rstrip(".")
    there = " in the chain made linear" if ending else ""
    symbols = ", ".join(f"{typeset(one)}: {said}" for one, said in _UNIT_WORDS.items() if one in _symbols(of))
    told = f"Unit: {typeset(of)} ({symbols})." if symbols else f"Unit: {of}."
    meaning = f"{words}: {what[:1].lower()}{what[1:]}{there}. {told}"
    return Quantity(name, f"{words} ({typeset(of)})", meaning, ending)


def typeset(unit: str) -> str:
    """A unit as it stands in a picture: "sqrt(m_T / k_T)" with a root and indices; one without symbols is words."""
    if not _symbols(unit) & {*_UNIT_WORDS}:
        return unit
    formula = re.sub(r"sqrt\((.*)\)", r"\\sqrt{\1}", unit).replace(" / ", "/").replace(" ", r"\,")
    upright = re.sub(r"_([a-z]+)", r"_\\mathrm{\1}", formula)
    return f"${upright}$"


def _symbols(unit: str) -> set[str]:
    return set(re.findall(r"\w+", unit))
