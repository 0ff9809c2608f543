"""The paper's five key findings as functions of data frames, each with a stated rule."""

import pandas as pd

from analysis.checks import require
from analysis.paper.findings.finding import Finding, in_place_of_ke, usable
from analysis.paper.findings.impacts import wide_range
from analysis.paper.findings.threshold import sharp_threshold
from analysis.paper.findings.viscosity import lower_viscosity
from analysis.paper.findings.waves import solitary_waves
from analysis.paper.findings.worse import worse_than_linear
from analysis.quantity import KE, ratio
from analysis.table import with_ratio
from sweep.errors import InputError


def findings(df: pd.DataFrame, of: str = KE.ratio) -> list[Finding]:
    """Which of the paper's five key findings hold, each by a stated rule.

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load` or of kernel.ke_ratios, for findings 1, 2, 3 and 5; or the profiles of figure 11 (the columns
        against, law, N, V_over_V0, n, v), for finding 4. Chaotic rows are left out; those that were not checked are
        not, and are counted. Of an unfinished table or a search give all rows (`load(path, done_only=False)`): by
        their status a finding knows that rows which it needs were not computed, or failed, and cannot tell; nor can it
        where a chain lacks the rows of impacts that others have.
    of : str
        The ratio that is judged in place of ke_ratio, lower being better: that of a quantity that the spec observes, as
        "wall_force_ratio".

    Returns
    -------
    list of Finding
        `number`, `claim`, `holds` (None where the frame cannot answer), `numbers`, `why`.

    Raises
    ------
    InputError
        For what is no ratio, missing or unusable columns, and for a table without a finished row that is not chaotic or
        with one N only.

    Examples
    --------
    >>> import analysis
    >>> df = analysis.load("quick.h5")
    >>> for finding in analysis.findings(df):    # doctest: +ELLIPSIS
    ...     print(finding.number, finding.verdict)
    1 ...
    2 ...
    3 ...
    5 ...
    """
    require(df, ())
    if (what := ratio(of)) != KE:
        rows = in_place_of_ke(df, what)
        with_ratio(df, what.ratio)  # names it where no row has it, as what reads `rows` cannot
        return [one.by(what) for one in findings(rows)]
    if "ke_ratio" not in df and "against" in df:
        return [solitary_waves(df)]
    rows, _ = usable(df)
    if rows["N"].nunique() < 2:
        raise InputError(f"every finding compares chains of different N, and there is only N = {rows['N'].iloc[0]}")
    return [rule(df) for rule in (lower_viscosity, sharp_threshold, worse_than_linear, wide_range)]
