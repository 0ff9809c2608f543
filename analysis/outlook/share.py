"""A share of a few trials, with the interval that it is known to."""

import numpy as np
from scipy.stats import norm

CONFIDENCE = 0.95


def share_of(some: int, total: int) -> tuple[float, float, float]:
    """The share and its interval by Wilson; nan where there was no trial."""
    if not total:
        return np.nan, np.nan, np.nan
    z, share = float(norm.ppf((1 + CONFIDENCE) / 2)), some / total
    middle = (share + z**2 / (2 * total)) / (1 + z**2 / total)
    reach = z / (1 + z**2 / total) * np.sqrt(share * (1 - share) / total + z**2 / (4 * total**2))
    return share, max(0.0, float(middle - reach)), min(1.0, float(middle + reach))
