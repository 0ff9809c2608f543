"""Every number of the paper beside ours, with a verdict."""

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

import kernel
from analysis.paper.convention import DRAWS, TOLERANCE, ratios
from analysis.paper.measured import MASS_SCALE, MEASURED, Ours
from analysis.paper.numbers import POINTS, SAID, Point
from analysis.paper.recipe import Source
from kernel.model import Array
from sweep.errors import InputError

AGREES, DIFFERS, ILL, OTHER = "agrees", "differs", "ill-conditioned", "agrees under another mass convention"
UNKNOWN = "cannot tell"  # ours differs, and its error is not known
ROUGH_FACTOR = 1.5  # the page states the factor to within which a number is compared if it is at least this one
GRID_STEP = 0.14  # natural logarithm of the factor between two impacts of figure 5
PLURAL = {"agrees": "agree", "differs": "differ", "holds": "hold", "does not hold": "do not hold"}
ILL_SPREAD = 0.1  # a number whose ensemble spreads by more than this share of its median is ill-conditioned


def compare(source: Source, points: Sequence[Point] = POINTS) -> pd.DataFrame:
    """One row per number: key, where, what, paper, ours, error, verdict, note."""
    rows = [_point_row(point) for point in points]
    for key, said in SAID.items():
        rough = f"; compared to within a factor of {said.factor:g}" if said.factor >= ROUGH_FACTOR else ""
        row = {"key": key, "where": said.where + rough, "what": said.what, "paper": said.paper}
        try:
            ours = MEASURED[key](source)
        except InputError as error:
            rows.append(row | {"ours": np.nan, "error": np.nan, "verdict": "not computed", "note": str(error)})
            continue
        rows.append(
            row
            | {
                "ours": ours.value,
                "error": ours.error,
                "verdict": verdict(said.paper, said.factor, ours),
                "note": ours.note + ("; a chaotic row" if ours.chaotic else ""),
            }
        )
    return pd.DataFrame(rows)


def verdict(paper: float, factor: float, ours: Ours) -> str:
    """The verdict on a number that may differ by `factor` and by our own error."""
    allowed = np.log(factor) + np.nan_to_num(ours.error) + 1e-9
    if abs(np.log(ours.value / paper)) <= allowed:
        return AGREES
    slack = GRID_STEP if ours.error == 0 else 0.0  # a value without an error is one value of a grid
    if ours.other_mass is not None and abs(np.log(ours.other_mass / paper)) <= allowed + slack:
        return OTHER
    return ILL if ours.chaotic else UNKNOWN if np.isnan(ours.error) else DIFFERS


def _point_row(point: Point) -> dict[str, object]:
    """The row of a ke_ratio: our value, the span over tasks that print alike, and that span at the other mass."""
    stated, other = ratios(point, "M_over_M0", np.array([1.0, MASS_SCALE]))
    result = kernel.ke_ratio(point.N, point.zeta_T, point.M_over_M0, point.V_over_V0, accuracy=1e-4)
    where = f"M/M0 = {point.M_over_M0:g}, V/V0 = {point.V_over_V0:g}, N = {point.N}, zeta_T = {point.zeta_T:g}"
    note = f"tasks that print alike give {_span(stated)}; with M/M0 over {1 / MASS_SCALE:.2f}, {_span(other)}"
    what = f"ke_ratio at {where}"
    return {"key": point.key, "where": point.where, "what": what, "paper": point.paper, "ours": result.ke_ratio,
            "error": result.error, "verdict": point_verdict(point.paper, stated, other), "note": note}  # fmt: skip


def point_verdict(paper: float, stated: Array, other: Array) -> str:
    """The verdict on a ke_ratio from its ensemble; a wide one that holds the paper's number decides nothing."""
    if _holds(stated, paper):
        return ILL if np.ptp(stated) > ILL_SPREAD * np.median(stated) else AGREES
    return OTHER if _holds(other, paper) else DIFFERS


def _holds(found: Array, paper: float) -> bool:
    return bool(found.min() * (1 - TOLERANCE) <= paper <= found.max() * (1 + TOLERANCE))


def _span(found: Array) -> str:
    return f"{found.min():.3g} to {found.max():.3g} ({DRAWS} draws)"


def tally(verdicts: Iterable[str]) -> str:
    """How often each verdict occurs, the most frequent first, for example "8 hold, 1 does not hold"."""
    return ", ".join(f"{count} {_verb(verdict, count)}" for verdict, count in Counter(verdicts).most_common())


def _verb(verdict: str, count: int) -> str:
    first = next((word for word in PLURAL if verdict.startswith(word)), None)
    return verdict if count == 1 or first is None else PLURAL[first] + verdict.removeprefix(first)
