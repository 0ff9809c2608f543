"""N_transition = A zeta_T^-b, by weighted least squares in logarithms, with a confidence interval (figure 6b)."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import t as student

from analysis.checks import choice, require
from analysis.transition import LINE
from sweep.errors import InputError

ZETA_T_MAX = 1e-2  # above, the transition is lost
LEAST = 4  # transitions of a fit
CONFIDENCE = 0.95
# Of the scatter that the brackets alone would give: transitions that agree better than this do so by chance.
CLOSEST = 0.1
COLUMN = {"log_slope": "N_transition", "slope": "by_slope", "level": "by_level"}
NEEDED = (*LINE, *COLUMN.values(), "N_low", "N_high")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PowerLaw:
    """One impact's law; made by `power_law`.

    Attributes
    ----------
    A, b : float
        N_transition = A zeta_T^-b.
    low, high : float
        Between which the exponent lies with a confidence of 95 %.
    points : int
        Transitions that it was fitted to.
    start, end : float
        The least and the largest of their zeta_T.
    """

    A: float
    b: float
    low: float
    high: float
    points: int
    start: float
    end: float


def power_law(found: pd.DataFrame, definition: str = "log_slope") -> PowerLaw | None:
    """The power law through the transitions of one impact.

    A transition counts by how narrow its bracket is, N_low to N_high, which is that of "log_slope" and stands for the
    other definitions too: all are known as well as the grid is fine there. How far it may be off is told by the scatter
    of all about the law, whatever its cause. Those at zeta_T = 0 or above ZETA_T_MAX, 1e-2, are left out.

    Parameters
    ----------
    found : pandas.DataFrame
        Rows of `transition`, of one M_over_M0 and V_over_V0.
    definition : str
        Of a transition: "log_slope", "slope" or "level" (analysis.transition.DEFINITIONS).

    Returns
    -------
    PowerLaw or None
        None where fewer than four zeta_T have a transition.

    Raises
    ------
    InputError
        For an unknown definition, missing or unusable columns, and rows of several impacts.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> found = analysis.transition(df[(df["M_over_M0"] == 2) & (df["V_over_V0"] == 10)])
    >>> law = analysis.power_law(found)
    >>> law is None or law.low < law.b < law.high
    True
    """
    choice("definition", definition, list(COLUMN))
    require(found, NEEDED, "found")
    if len(found.drop_duplicates(LINE[:2])) > 1:
        raise InputError("found: must hold the transitions of one M_over_M0 and V_over_V0; power_laws takes several")
    return _law(found, COLUMN[definition])


def _law(found: pd.DataFrame, column: str) -> PowerLaw | None:
    rows = found[(found["zeta_T"] > 0) & (found["zeta_T"] <= ZETA_T_MAX) & found[column].notna()]
    if rows["zeta_T"].nunique() < LEAST:
        return None
    x, y = np.log(rows["zeta_T"].to_numpy(float)), np.log(rows[column].to_numpy(float))
    sigma = np.log((rows["N_high"] / rows["N_low"]).to_numpy(float)) / np.sqrt(12.0)  # of a uniform distribution
    (slope, level), covariance = np.polyfit(x, y, 1, w=1.0 / sigma, cov="unscaled")
    freedom = len(x) - 2
    scatter = np.sqrt(np.sum(((y - level - slope * x) / sigma) ** 2) / freedom)
    error = max(scatter, CLOSEST) * np.sqrt(covariance[0, 0])
    reach = float(student.ppf((1 + CONFIDENCE) / 2, freedom) * error)
    b, (start, end) = float(-slope), np.exp(x[[np.argmin(x), np.argmax(x)]])
    return PowerLaw(float(np.exp(level)), b, b - reach, b + reach, len(x), float(start), float(end))


def power_laws(found: pd.DataFrame) -> pd.DataFrame:
    """The power law of every impact, by every definition of a transition.

    Parameters
    ----------
    found : pandas.DataFrame
        Rows of `transition`.

    Returns
    -------
    pandas.DataFrame
        One row per impact and definition that has a law: M_over_M0, V_over_V0, definition, A, b, b_low, b_high (95 %),
        points.

    Raises
    ------
    InputError
        For missing or unusable columns.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> analysis.power_laws(analysis.transition(df)).columns.tolist()
    ['M_over_M0', 'V_over_V0', 'definition', 'A', 'b', 'b_low', 'b_high', 'points']
    """
    require(found, NEEDED, "found")
    laws = []
    for (M, V), rows in found.groupby(LINE[:2]):
        for definition, column in COLUMN.items():
            if law := _law(rows, column):
                numbers = {"A": law.A, "b": law.b, "b_low": law.low, "b_high": law.high, "points": law.points}
                laws.append({"M_over_M0": M, "V_over_V0": V, "definition": definition} | numbers)
    columns = ["M_over_M0", "V_over_V0", "definition", "A", "b", "b_low", "b_high", "points"]
    return pd.DataFrame(laws, columns=columns)
