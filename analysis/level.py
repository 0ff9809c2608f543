"""Where a quantity crosses a level along one axis: the smallest N at which a chain protects, and the like."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import TEXT, choice, inputs, require, require_numbers_of_model
from analysis.plane import check_names
from analysis.quantity import KE, shown_by
from analysis.table import LineRows, calm_line, done_lines, finished, has_number, no_number
from kernel.hints import shown
from kernel.task import is_finite
from sweep.errors import InputError, gathered
from sweep.plan.crossing import FIRST, LAST, START_MIN, bracket

FOUND = ("low", "high", "at_low", "at_high")  # nan where the level is not crossed


def crossings(df: pd.DataFrame, level: float, along: str = "N", of: str = KE.ratio, which: str = FIRST) -> pd.DataFrame:
    """Between which values of an axis a quantity crosses a level, on every line along that axis.

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load` or of kernel.ke_ratios. Chaotic ones are left out, those that were not checked are not.
    level : float
        The level, in the unit of the quantity.
    along : str
        The axis: N, zeta_T, M_over_M0, V_over_V0 or a number of the model.
    of : str
        The column of the quantity.
    which : str
        "first" or "last" crossing, up or down, as the axis rises.

    Returns
    -------
    pandas.DataFrame
        One row per line, a combination of the other inputs. The level is crossed between `low` and `high`, neighbours
        among the values of the axis that are used, at which the quantity is `at_low` and `at_high`; `skipped`
        rows of `df` lie between them: chaotic, failed or still to come, but none that a search did not ask for.
        `sure`: whether both differ from the level by more than their estimated error (None where that is not
        known). `why_not` says why there is no crossing (nan then). `rows` were used, of which `unchecked` were
        not checked for chaos; `chaotic` ones were left out, and `without` that have no such quantity, as that
        of a site that is not reached; `failed` rows had ended without a number. A crossing may hide behind what
        is left out.

    Raises
    ------
    InputError
        Where an argument or a column cannot be used, or nothing is finished.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> found = analysis.crossings(df, 1.0, along="N")
    >>> bool((found["low"] < found["high"]).equals(found["why_not"] == ""))
    True
    """
    known = inputs(df)
    columns = [of] if isinstance(of, str) and of not in TEXT else []
    gathered(
        lambda: _check_level(level),
        lambda: choice("which", which, (FIRST, LAST)),
        lambda: check_names([along], known),
        lambda: _check_column(of),
        lambda: require(df, [*known, *columns, "chaotic"]),
    )
    done = finished(df)
    require_numbers_of_model(done)
    if not has_number(done, of).any():
        raise InputError(f"no finished row has a {of}")
    names = [name for name in known if name != along]
    if len(done) > 1 and done.groupby(names)[along].nunique().max() < 2:
        raise InputError(
            f"{len(done)} rows form no lines along {along}: none has two values of it where all else is alike; "
            "`analysis points` draws them where they are"
        )
    lines = done_lines(df, names)
    return pd.DataFrame([key | _line(line, along, of, level, which) for key, line in lines])


def _check_level(level: object) -> None:
    if not is_finite(level):
        raise InputError(f"level: must be a finite number, got {shown(level)}")


def _check_column(of: object) -> None:
    if not isinstance(of, str) or of in TEXT:
        raise InputError(f"of: must be the name of a column of numbers, got {shown(of)}")


def _line(line: LineRows, along: str, of: str, level: float, which: str) -> dict[str, Any]:
    sharp, counts = calm_line(line.done, along, of)
    counts |= {"failed": len(line.failed), "skipped": 0}
    axis, values = (sharp[name].to_numpy(float) for name in (along, of))
    found = bracket(values.tolist(), level, which)
    if found is None:
        why = no_number(line.done, counts, of) or _why_not(values, level)
        return counts | {"why_not": why, "sure": None} | dict.fromkeys(FOUND, np.nan)
    ends = slice(found, found + 2)
    every = np.unique(np.concatenate([rows[along] for rows in line]))
    counts["skipped"] = int(np.count_nonzero((axis[found] < every) & (every < axis[found + 1])))
    told = dict(zip(FOUND, (*axis[ends], *values[ends]), strict=True))
    return counts | {"why_not": "", "sure": _sure(sharp.iloc[ends], of, level)} | told


def _why_not(values: NDArray[np.float64], level: float) -> str:
    """Why these values cross no level."""
    if len(values) < START_MIN:
        return f"fewer than {START_MIN} values" if len(values) else "chaotic"
    return f"{'above' if values[0] >= level else 'below'} throughout"


def _sure(ends: pd.DataFrame, of: str, level: float) -> bool | None:
    """Whether two rows lie on either side of the level, as their errors tell."""
    column = _error_of(of)
    error = ends[column].to_numpy(float, na_value=np.nan) if column in ends else [np.nan]
    if not np.isfinite(error).all():
        return None
    values = ends[of].to_numpy(float)
    return bool((np.abs(values - level) > error * np.abs(values)).all())


def unsure_of(found: pd.DataFrame) -> int:
    """Of how many crossings an end is the level within its error, as far as that is known."""
    return sum(sure is False for sure in found["sure"])


def _error_of(of: str) -> str:
    """The column of the estimated relative error of a column; empty where nobody tells it."""
    try:
        known = shown_by(of)
    except InputError:
        return ""
    return "" if known.error_of else known.error
