"""What a finding is, which rows speak for it, and how the rows are counted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import require, require_one_chain
from analysis.paper.numbers import COARSE_N, FINE_N, MAJORITY
from analysis.quantity import KE, Quantity
from analysis.ruler import RELATIVE_MATCH
from analysis.table import (
    DONE_LABEL,
    TO_COME,
    UNASKED_LABEL,
    checked,
    flagged,
    left_out,
    pairs_of,
    reasons_text,
    with_ratio,
)
from kernel.notebook import ShownAsTable
from sweep.errors import InputError
from sweep.schema import PARAMETERS

COLUMNS = (*PARAMETERS, "ke_ratio", "error", "chaotic")

Array = NDArray[np.float64]
Numbers = dict[str, float | int | str]


@dataclass(frozen=True)
class Finding(ShownAsTable):
    """One of the paper's five key findings, on one frame; made by `findings`.

    Attributes
    ----------
    number : int
        1 to 5, as the paper's.
    claim : str
        What the paper finds.
    holds : bool or None
        None where the frame cannot answer.
    numbers : dict
        What the rule compared, by name.
    why : str
        The rule that decided, or what the frame lacks.
    verdict, text : str
        `holds`, and `numbers`, in words.
    """

    number: int
    claim: str
    holds: bool | None
    numbers: Numbers
    why: str

    @property
    def verdict(self) -> str:
        """`holds` in words."""
        return {True: "holds", False: "does not hold", None: "cannot tell"}[self.holds]

    @property
    def text(self) -> str:
        """The numbers, in one line."""
        texts = (f"{value:.3g}" if isinstance(value, float) else str(value) for value in self.numbers.values())
        return "; ".join(f"{name}: {text}" for name, text in zip(self.numbers, texts, strict=True))

    def by(self, of: Quantity) -> "Finding":
        """As the rules tell it of another ratio, which was `in_place_of_ke`: with its name in their words."""
        numbers = {name.replace(KE.ratio, of.ratio): value for name, value in self.numbers.items()}
        return replace(self, numbers=numbers, why=self.why.replace(KE.ratio, of.ratio))


def in_place_of_ke(df: pd.DataFrame, of: Quantity, more_is_better: bool = False) -> pd.DataFrame:
    """The rows with another ratio in place of ke_ratio, for the rules to read; its inverse where more is better.

    Where it is no finite number above 0 there is none: undamped chains dissipate nothing.
    """
    require(df, [of.ratio, of.error, "chaotic"])
    with np.errstate(divide="ignore"):
        ratio = 1 / df[of.ratio] if more_is_better else df[of.ratio]
    return df.assign(ke_ratio=ratio.where(np.isfinite(ratio) & (ratio > 0)), error=df[of.error])


def usable(df: pd.DataFrame) -> tuple[pd.DataFrame, Numbers]:
    """The finished rows that are not known to be chaotic, and how many rows were used, not checked, and left out.

    InputError where columns are missing or hold words, or no such row is there.
    """
    require(df, COLUMNS)
    require_one_chain(df)
    numbers = with_ratio(df, "ke_ratio")
    rows = numbers[~flagged(numbers)]
    if rows.empty:
        raise InputError("every finished row is chaotic: none tells whether a finding holds")
    unchecked = int((~checked(rows)).sum())
    return rows, {
        "rows": len(rows),
        **({"not checked for chaos": unchecked} if unchecked else {}),
        **{f"{why}, left out": count for why, count in left_out(df, KE.ratio, above=0).items()},
    }


def none_counts(df: pd.DataFrame, which: str) -> str:
    """That none of these rows is usable, and why."""
    reasons = {why: count for why, count in left_out(df, KE.ratio, above=0).items() if count}
    return f"no row with {which}{' counts: ' if reasons else ''}{reasons_text(reasons)}"


def waiting(needed: pd.DataFrame, df: pd.DataFrame) -> str:
    """What to say where not all the rows that a rule needs of `df` have been computed; empty where all have.

    Of each chain it needs every impact of `df`: where rows were chosen, as those that a merged search has computed, the
    others are in no table.
    Those that a search leaves out are left out for what they are likely to be: the others tell nothing of them.
    """
    status = _lost(needed) if "status" in needed else pd.Series(dtype=str)
    unasked = bool((status == UNASKED_LABEL).any())
    held, pairs = pairs_of(needed, df)
    kinds = {
        "not computed by this search" if unasked else "yet to be computed": int(status.isin(TO_COME).sum()),
        "failed": int((~status.isin(TO_COME)).sum()),
        "not in the table": pairs - held,
    }
    lost = ", ".join(f"{count} of them {why}" for why, count in kinds.items() if count)
    return f"needs all of {len(needed) + pairs - held} rows; {lost}" if lost else ""


def _lost(needed: pd.DataFrame) -> "pd.Series[str]":
    """The status of the rows without a number, but of those whose task has been done in another row."""
    status = needed["status"].astype(str)
    if (done := status == DONE_LABEL).all():
        return status[~done]
    tasks = pd.MultiIndex.from_frame(needed[list(PARAMETERS)])
    return status[~tasks.isin(tasks[done])]


def waiting_lines(df: pd.DataFrame, most: float) -> str:
    """The same of a rule on lines in N up to this damping: they need both ends, and between them some rows may do."""
    rows = damped(df, most)
    return waiting(rows[rows["N"].isin([rows["N"].min(), rows["N"].max()])], df)


def both(*parts: bool | None) -> bool | None:
    """Whether all hold: False if one fails, else None if one is open."""
    if False in parts:
        return False
    return None if None in parts else True


def most(votes: "Sequence[bool] | pd.Series[bool]") -> bool | None:
    """Whether at least MAJORITY of the votes are for it; None without votes."""
    return bool(np.mean(votes) >= MAJORITY) if len(votes) else None


def ordered(x: Array, y: Array) -> float:
    """Share of all pairs in which the larger x has the larger y: 1 where y rises, 0 where it falls or is flat."""
    rising = y[np.argsort(x)]
    lower, upper = np.triu_indices(len(rising), 1)
    return float(np.mean(rising[upper] > rising[lower]))


def damped(rows: pd.DataFrame, most: float, least: float = 0.0) -> pd.DataFrame:
    """The rows with 0 < zeta_T, and `least` <= zeta_T <= `most`."""
    zeta_T = rows["zeta_T"]
    return rows[(zeta_T > 0) & (zeta_T >= least * (1 - RELATIVE_MATCH)) & (zeta_T <= most * (1 + RELATIVE_MATCH))]


def reaches(line: pd.DataFrame) -> bool:
    """Whether the line has chains of COARSE_N or fewer and of FINE_N or more cells."""
    return bool(len(line) and line["N"].min() <= COARSE_N and line["N"].max() >= FINE_N)
