"""N_transition = A zeta_T^-b, by weighted least squares in logarithms, with a confidence interval (figure 6b)."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from analysis.checks import choice, require
from analysis.paper.numbers import HIGH_DAMPING
from analysis.table import IMPACT
from analysis.transition import DEFINITIONS, FOUND, LINE
from kernel.notebook import ShownAsTable
from sweep.errors import InputError

MIN_TRANSITIONS = 4  # of a fit: two degrees of freedom are left to judge the scatter by
CONFIDENCE = 0.95
EVEN_WIDTH = np.sqrt(12.0)  # width of an even distribution over its standard deviation
NEEDED = (*LINE, *FOUND)


@dataclass(frozen=True)
class TransitionLaw(ShownAsTable):
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


def power_law(found: pd.DataFrame, definition: str = "log_slope") -> TransitionLaw | None:
    """The power law through the transitions of one impact (the paper's figure 6b).

    A transition counts by how narrow its bracket is, N_low to N_high. The bracket is that of "log_slope" and serves the
    other definitions too: every one is known as well as the grid is fine there. The interval of the exponent follows
    from the scatter of the transitions about the law, and is never narrower than the brackets allow. Those at
    zeta_T = 0 or above 1e-2 are left out.

    Parameters
    ----------
    found : pandas.DataFrame
        Rows of `transition`, of one M_over_M0 and V_over_V0.
    definition : str
        Of a transition: "log_slope", "slope" or "level" (analysis.transition.DEFINITIONS).

    Returns
    -------
    TransitionLaw or None
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
    choice("definition", definition, list(DEFINITIONS))
    require(found, NEEDED, "found")
    if len(found.drop_duplicates(IMPACT)) > 1:
        raise InputError("found: must hold the transitions of one M_over_M0 and V_over_V0; power_laws takes several")
    return _law(found, DEFINITIONS[definition].column)


def _law(found: pd.DataFrame, column: str) -> TransitionLaw | None:
    if (rows := fitted(found, column)) is None:
        return None
    one, zeta_T = line_through(rows, column), rows["zeta_T"]
    ends = float(zeta_T.min()), float(zeta_T.max())
    return TransitionLaw(float(np.exp(one.level)), one.b, one.b - one.reach, one.b + one.reach, len(rows), *ends)


def fitted(found: pd.DataFrame, column: str = "N_transition") -> pd.DataFrame | None:
    """The rows of `transition` to which the law of one impact is fitted; None where there are too few."""
    rows = found[(found["zeta_T"] > 0) & (found["zeta_T"] <= HIGH_DAMPING) & found[column].notna()]
    return rows if rows["zeta_T"].nunique() >= MIN_TRANSITIONS else None


class FittedLine(NamedTuple):
    """log N_transition = level - b log(zeta_T / middle); the confidence interval of each reaches so far either way."""

    b: float
    reach: float
    level: float
    reach_of_level: float


def line_through(rows: pd.DataFrame, column: str = "N_transition", middle: float = 1.0) -> FittedLine:
    """The weighted line through the rows of `fitted`, its level told at a zeta_T of `middle`."""
    # Quantiles of the normal and of Student's distribution; other commands need not wait until they are loaded.
    from scipy.special import ndtri, stdtrit

    x, y = np.log(rows["zeta_T"].to_numpy(float) / middle), np.log(rows[column].to_numpy(float))
    sigma = np.log((rows["N_high"] / rows["N_low"]).to_numpy(float)) / EVEN_WIDTH
    (slope, level), covariance = np.polyfit(x, y, 1, w=1.0 / sigma, cov="unscaled")
    freedom = len(x) - 2
    scatter = np.sqrt(np.sum(((y - level - slope * x) / sigma) ** 2) / freedom)
    # Where a step in zeta_T moves every transition by whole steps of N, they lie on a line, off by as much as the
    # brackets allow. These are known, so a normal quantile serves; the scatter is that of few points. In 2000 draws of
    # b each, on 6 to 90 N and 4 to 20 zeta_T in even steps, the wider held b in 93 to 100 %, the scatter alone in 67
    # to 100 %.
    quantile = (1 + CONFIDENCE) / 2
    reach = max(stdtrit(freedom, quantile) * scatter, ndtri(quantile)) * np.sqrt(np.diag(covariance))
    return FittedLine(float(-slope), float(reach[0]), float(level), float(reach[1]))


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
    for (M, V), rows in found.groupby(IMPACT):
        for definition, (_, column, _) in DEFINITIONS.items():
            if law := _law(rows, column):
                numbers = {"A": law.A, "b": law.b, "b_low": law.low, "b_high": law.high, "points": law.points}
                laws.append({"M_over_M0": M, "V_over_V0": V, "definition": definition} | numbers)
    columns = [*IMPACT, "definition", "A", "b", "b_low", "b_high", "points"]
    return pd.DataFrame(laws, columns=columns)


def beside_laws(found: pd.DataFrame, laws: pd.DataFrame) -> pd.DataFrame:
    """The transitions, and with each the `power_laws` of its impact: A, b, b_low, b_high, points; nan without a law.

    Those by the other definitions have the name of their column behind them: b_by_slope, b_by_level.
    """
    numbers = ["A", "b", "b_low", "b_high", "points"]
    for name, definition in DEFINITIONS.items():
        ending = "" if name == next(iter(DEFINITIONS)) else f"_{definition.column}"
        own = laws[laws["definition"] == name].set_index(IMPACT)[numbers].add_suffix(ending)
        found = found.join(own, on=IMPACT)
    return found
