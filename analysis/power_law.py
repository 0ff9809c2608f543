"""N_transition = A zeta_T^-b, by weighted least squares in logarithms, with a bootstrap interval (figure 6b)."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import choice, require
from analysis.transition import LINE

ZETA_T_MAX = 1e-2  # above, the transition is lost
LEAST = 4  # transitions of a fit
DRAWS = 1000
COLUMN = {"log_slope": "N_transition", "slope": "by_slope", "level": "by_level"}

NEEDED = (*LINE, *COLUMN.values(), "N_low", "N_high")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PowerLaw:
    """One impact's; `low` and `high` hold b in 95 of 100 bootstrap draws over the transitions."""

    A: float
    b: float
    low: float
    high: float
    points: int

    @property
    def spread(self) -> float:
        """Half of the interval's width over two: comparable to a standard error."""
        return (self.high - self.low) / 4.0


def power_law(found: pd.DataFrame, definition: str = "log_slope") -> PowerLaw | None:
    """Through the transitions of one impact (rows of `transition`); None where fewer than LEAST have one.

    A transition counts by how narrow its bracket is. Those at zeta_T = 0 or above ZETA_T_MAX are left out.
    """
    choice("definition", definition, list(COLUMN))
    require(found, NEEDED, "found")
    column = COLUMN[definition]
    rows = found[(found["zeta_T"] > 0) & (found["zeta_T"] <= ZETA_T_MAX) & found[column].notna()]
    if len(rows) < LEAST:
        return None
    x, y = np.log(rows["zeta_T"].to_numpy(float)), np.log(rows[column].to_numpy(float))
    widths = np.log((rows["N_high"] / rows["N_low"]).to_numpy(float))
    sigma = widths / np.sqrt(12.0)  # of a uniform distribution
    level, b = _fit(x, y, sigma)
    rng, draws = np.random.default_rng(0), list[float]()
    while len(draws) < DRAWS:
        chosen = rng.integers(len(x), size=len(x))
        if len(np.unique(chosen)) >= 3:
            draws.append(_fit(x[chosen], y[chosen], sigma[chosen])[1])
    low, high = np.quantile(draws, [0.025, 0.975])
    return PowerLaw(float(np.exp(level)), b, float(low), float(high), len(x))


def _fit(x: Array, y: Array, sigma: Array) -> tuple[float, float]:
    level, slope = np.polynomial.polynomial.polyfit(x, y, 1, w=1.0 / sigma)
    return float(level), float(-slope)


def power_laws(found: pd.DataFrame) -> pd.DataFrame:
    """One row per impact and definition: M_over_M0, V_over_V0, definition, A, b, b_low, b_high, points."""
    require(found, NEEDED, "found")
    laws = []
    for (M, V), rows in found.groupby(LINE[:2]):
        for definition in COLUMN:
            if law := power_law(rows, definition):
                numbers = {"A": law.A, "b": law.b, "b_low": law.low, "b_high": law.high, "points": law.points}
                laws.append({"M_over_M0": M, "V_over_V0": V, "definition": definition} | numbers)
    columns = ["M_over_M0", "V_over_V0", "definition", "A", "b", "b_low", "b_high", "points"]
    return pd.DataFrame(laws, columns=columns)
