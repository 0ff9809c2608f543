"""What is not known is never counted as known: rows that were not checked for chaos, errors that were not estimated."""

import itertools

import numpy as np
import pandas as pd
import pytest

import analysis
import kernel
from analysis import report
from analysis.notes import Notes, of_best, of_plane
from analysis.table import checked, flagged

GRID = {"N": [20, 50, 200], "zeta_T": [4e-5, 4e-4], "M_over_M0": [0.5, 2.0], "V_over_V0": [1.0, 4.0]}


def table(**columns):
    """Rows that nobody checked: as `load` gives them."""
    rows = pd.DataFrame(itertools.product(*GRID.values()), columns=list(GRID))
    ratio = 30.0 / rows["N"] * (1 + rows["zeta_T"]) / rows["V_over_V0"] * rows["M_over_M0"] ** 0.3
    missing = pd.array([pd.NA] * len(rows), dtype="boolean")
    return rows.assign(
        **{"ke_ratio": ratio, "error": np.nan, "chaotic": missing, "checked": False, "status": "done"} | columns
    )


FORMS = {
    "as loaded": table(),
    "as computed": table(chaotic=False),
    "without the column checked": table(chaotic=False).drop(columns="checked"),
    "read from a CSV": table(chaotic=np.nan),
    "of mixed objects": table(chaotic=None),
}


@pytest.mark.parametrize("df", FORMS.values(), ids=FORMS)
def test_whatever_form_the_flag_has_nothing_is_flagged_and_nothing_was_checked(df):
    assert not flagged(df).any()
    assert not checked(df).any()


@pytest.mark.parametrize("df", FORMS.values(), ids=FORMS)
def test_an_optimum_without_an_error_has_no_interval(df):
    found = analysis.optimum(df)
    assert np.isnan([found.low, found.high]).all()
    assert (found.chaotic, found.rivals) == (None, None)
    assert np.isnan(list(found.between.values())).all()
    assert str(found).startswith("ke_ratio = 0.03046 (error not estimated, not checked for chaos) at N = 200, zeta_T")
    assert " to " not in str(found)


def test_an_optimum_with_an_error_has_one_as_before_and_counts_what_has_none_by_its_value():
    known = table(error=0.1, chaotic=False, checked=True)
    found = analysis.optimum(known)
    assert found.chaotic is False
    assert found.low < found.ke_ratio < found.high
    twin = known.iloc[[int(known["ke_ratio"].argmin())]]
    vague = twin.assign(zeta_T=1e-3, ke_ratio=[found.ke_ratio * 1.05], error=np.nan, checked=False)
    assert analysis.optimum(pd.concat([known, vague])).rivals == found.rivals + 1


@pytest.mark.parametrize("df", FORMS.values(), ids=FORMS)
def test_every_function_takes_them_and_says_that_they_were_not_checked(df):
    cells = analysis.best(df)
    assert len(cells) == 6
    assert not checked(cells).any()
    plane = analysis.plane(df, ("N", "zeta_T"), {"M_over_M0": 2, "V_over_V0": 1})
    assert not checked(plane).any()
    assert analysis.map_over(df, at={"M_over_M0": 2, "V_over_V0": 1}).shape == (2, 3)
    collapsed = analysis.collapse(df)
    assert "chaotic" not in collapsed.left_out
    assert collapsed.unchecked == "not checked for chaos"
    assert str(collapsed).endswith("; not checked for chaos")
    lines = analysis.transition(df)
    assert (lines["unchecked"] == lines["rows"]).all()
    assert all(one.numbers["not checked for chaos"] == len(df) for one in analysis.findings(df))


@pytest.mark.parametrize("df", FORMS.values(), ids=FORMS)
def test_reports_say_not_checked_and_count_no_chaos(df):
    cells = analysis.best(df)
    best, over = of_best(df, df, cells), ("N", "zeta_T")
    map_ = of_plane(df, cells, over)
    lines = [
        *report.rows_used(df, df, cells, best),
        *report.plane_used(df, cells, cells, over, map_),
        *report.lowest(cells, Notes()),
    ]
    assert not any("hatched" in line for line in lines)
    assert [line for line in lines if "not checked for chaos" in line] == lines[2:3] + lines[4:]
    assert "error not estimated" in lines[-1]


def test_where_some_were_checked_both_numbers_are_told():
    df = table(chaotic=False, error=1e-4, checked=True)
    df.loc[df["N"] == 20, "chaotic"] = True
    df.loc[df["N"] == 200, ["checked", "error"]] = [False, np.nan]
    cells = analysis.best(df, chaotic_too=True)
    (_, _, line) = report.rows_used(df, df, cells, of_best(df, df, cells, chaotic_too=True))
    assert "hatched: 2 cells whose lowest row is chaotic; 2 not checked for chaos" in line
    beside_cells = of_best(df, df, cells, chaotic_too=True).unchecked
    assert beside_cells == f"{(df['N'] == 200).sum()} rows not checked for chaos", "of rows, of which a cell has many"


def test_a_chaotic_row_gives_way_to_one_that_was_not_checked_and_a_checked_table_says_nothing_of_it():
    df = table(chaotic=False, error=1e-4, checked=True)
    df.loc[df["V_over_V0"] == 4, "chaotic"] = True
    df.loc[df["V_over_V0"] == 1, ["checked", "error"]] = [False, np.nan]
    cells = analysis.best(df)
    assert (cells["V_over_V0"] == 1).all()
    assert not checked(cells).any()
    sure = table(chaotic=False, error=1e-4, checked=True)
    cells = analysis.best(sure)
    lines = [*report.rows_used(sure, sure, cells, Notes()), *report.lowest(cells, Notes())]
    assert not any("not checked" in line for line in lines)


def test_pending_rows_have_not_failed():
    df = table(chaotic=False, error=1e-4, checked=True)
    more = pd.concat([df, df.head(3).assign(status="pending"), df.head(2).assign(status="unasked")])
    more = pd.concat([more, *(df.head(1).assign(status=word) for word in ("not_finite", "torn"))], ignore_index=True)
    left_out = analysis.collapse(more).left_out
    assert left_out == {"pending": 3, "unasked": 2, "torn": 1, "failed": 1, "chaotic": 0, "without damping": 0}


@pytest.mark.parametrize("certify", [True, False])
def test_what_the_kernel_gives_goes_straight_into_every_function(certify):
    tasks = pd.DataFrame(itertools.product(*(GRID | {"N": [5, 10, 20]}).values()), columns=list(GRID))
    df = pd.DataFrame(kernel.ke_ratios(tasks, 1e-2, certify=certify))
    assert len(analysis.best(df)) == 6
    assert np.isfinite(analysis.optimum(df).high) == certify
    assert len(analysis.plane(df, at={"M_over_M0": 2, "V_over_V0": 1})) == 6
    assert analysis.map_over(df, at={"M_over_M0": 2, "V_over_V0": 1}).shape == (2, 3)
    assert len(analysis.collapse(df, "Pi_IE").rows) >= 20
    found = analysis.transition(df)
    assert len(found) == 8
    assert analysis.power_law(found[(found["M_over_M0"] == 2) & (found["V_over_V0"] == 1)]) is None
    assert analysis.power_laws(found).empty
    assert [one.number for one in analysis.findings(df)] == [1, 2, 3, 5]


def test_a_task_that_failed_is_no_finished_row():
    df = pd.DataFrame(kernel.ke_ratios({"N": [10, 1], "zeta_T": 1e-2, "M_over_M0": 1, "V_over_V0": 1}, 1e-1))
    assert list(analysis.best(df)["N"]) == [10]


def test_a_chaotic_cell_as_low_as_the_lowest_is_not_called_lower():
    df = table(chaotic=False, error=1e-4, checked=True)
    df.loc[df["N"] == 20, "chaotic"] = True
    cells = analysis.best(df)
    low = cells.loc[~cells["chaotic"].astype(bool), "ke_ratio"].min()
    cells.loc[cells["chaotic"].astype(bool), "ke_ratio"] = low
    (line,) = report.lowest(cells, Notes())
    assert line.startswith("lowest")
    cells.loc[cells["chaotic"].astype(bool), "ke_ratio"] = 0.5 * low
    assert [word.partition(" ")[0] for word in report.lowest(cells, Notes())] == ["chaotic", "lowest"]
