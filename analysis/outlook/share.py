"""A share of a few trials, with the interval that it is known to."""

import numpy as np
from scipy.stats import binomtest

CONFIDENCE = 0.95


def share_of(some: int, total: int) -> tuple[float, float, float]:
    """The share and its interval by Wilson; nan where there was no trial."""
    if not total:
        return np.nan, np.nan, np.nan
    interval = binomtest(some, total).proportion_ci(CONFIDENCE, "wilson")
    return some / total, float(interval.low), float(interval.high)
