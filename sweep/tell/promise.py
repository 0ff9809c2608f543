"""What a table promises about its errors, and whether a sample of true errors breaks it.

Of the rows that are not chaotic at least 95 % are within the target, and at least 95 % are covered by their stated
`error`. A sample breaks a promise only if a table that keeps it would hardly ever give one as bad.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.method import SWITCH

FRACTION = 0.01  # of the done rows are recomputed, unless the user asks for another share
SAMPLE_MIN = 30  # rows, or all that there are: with fewer, even a table of many bad rows would seem to keep its promise
PROMISED = 0.95  # of the rows that are not chaotic; what the kernel keeps: `python -m tests.promises`
SIGNIFICANCE = 0.01  # one sample in a hundred of a table that just keeps a promise is called broken
REGIONS = ("undamped", "weakly damped", "stiffly damped")  # N zeta_T is 0, below SWITCH, above
QUANTILES = (0.5, 0.9, 1.0)
TRUE_ERROR_MIN = float(np.finfo(float).eps)  # before something is divided by it: errors below it are rounding


class Audited(NamedTuple):
    """Rows of a table beside their references; one entry per row."""

    zeta: NDArray[np.float64]  # N zeta_T
    chaotic: NDArray[np.bool_]
    true: NDArray[np.float64]  # relative error of ke_ratio against the reference
    stated: NDArray[np.float64]  # the table's `error`, nan where not estimated

    def some(self, where: NDArray[np.bool_]) -> "Audited":
        """The rows where `where`."""
        return Audited(self.zeta[where], self.chaotic[where], self.true[where], self.stated[where])


def judge(rows: Audited, target: float | None, certified: bool) -> list[dict[str, Any]]:
    """One verdict for each promise of the table: there is none on the target where the user gave tolerances, and none
    on the stated errors where nothing was certified."""
    firm = rows.some(~rows.chaotic)
    verdicts = []
    if target is not None:
        verdicts.append(_verdict("within target", int((firm.true <= target).sum()), len(firm.true)))
    if certified:
        verdicts.append(_verdict("covered by error", int((firm.true <= firm.stated).sum()), len(firm.true)))
    return verdicts


def _verdict(promise: str, good: int, rows: int) -> dict[str, Any]:
    chance = chance_of_misses(rows - good, rows)
    return {"promise": promise, "good": good, "rows": rows, "chance": chance, "broken": chance < SIGNIFICANCE}


def chance_of_misses(misses: int, rows: int) -> float:
    """Probability of so many misses or more among `rows` where each misses with 1 - PROMISED (binomial)."""
    from scipy.stats import binom  # takes seconds to load, for which other commands need not wait

    return float(binom.sf(misses - 1, rows, 1.0 - PROMISED))


def regions(rows: Audited, target: float | None, certified: bool) -> list[dict[str, Any]]:
    """The errors region by region, chaotic rows apart from the others; regions without rows are left out."""
    place = np.where(rows.zeta == 0.0, 0, np.where(rows.zeta < SWITCH, 1, 2))
    return [
        {"region": region, "chaotic": chaotic} | _errors(rows.some(where), target, certified)
        for chaotic in (False, True)
        for i, region in enumerate(REGIONS)
        if (where := (place == i) & (rows.chaotic == chaotic)).any()
    ]


def _errors(rows: Audited, target: float | None, certified: bool) -> dict[str, Any]:
    ratio = rows.stated / np.maximum(rows.true, TRUE_ERROR_MIN)
    return {
        "rows": len(rows.true),
        "true_error": _quantiles(rows.true),
        "stated_over_true": _quantiles(ratio) if certified else None,
        "within_target": float(np.mean(rows.true <= target)) if target is not None else None,
        "covered": float(np.mean(rows.true <= rows.stated)) if certified else None,
    }


def _quantiles(values: NDArray[np.float64]) -> dict[str, float]:
    """Quantiles that occur as values: between two of a few nothing is interpolated."""
    return {f"{q:.0%}": float(np.quantile(values, q, method="inverted_cdf")) for q in QUANTILES}
