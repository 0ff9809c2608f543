"""The optimum is the lowest row, and its interval holds whatever the table cannot tell from it."""

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis import InputError, best, optimum
from analysis.optimum import optimum_on

GRID = {"N": [10, 100], "zeta_T": [1e-4, 1e-2], "M_over_M0": [0.1, 1.0, 10.0], "V_over_V0": [1.0, 2.0, 4.0, 8.0]}


def table(ratio=lambda rows: 1 + (np.log10(rows["M_over_M0"]) ** 2) + rows["V_over_V0"] / rows["N"], **columns):
    rows = pd.DataFrame(itertools.product(*GRID.values()), columns=list(GRID))
    return rows.assign(ke_ratio=ratio(rows), **({"error": 1e-6, "chaotic": False} | columns))


def test_it_is_the_lowest_of_the_best_of_every_cell():
    found, cells = optimum(table()), best(table())
    row = cells.loc[cells["ke_ratio"].idxmin()]
    assert found.ke_ratio == row["ke_ratio"]
    assert found.at == {name: row[name] for name in GRID}


def test_a_sharp_optimum_lies_within_half_a_step_of_the_grid():
    found = optimum(table(lambda rows: 1 + np.log10(rows["M_over_M0"]) ** 2 + abs(rows["V_over_V0"] - 2) + rows["N"]))
    assert found.rivals == 2 - 1  # zeta_T does not matter here
    assert str(found).endswith("; 1 other row may be as low")
    assert found.between["M_over_M0"] == pytest.approx((10**-0.5, 10**0.5))
    assert found.between["V_over_V0"] == pytest.approx((2**0.5, 2**1.5))
    assert found.between["zeta_T"] == pytest.approx((1e-4, 1e-2))
    assert found.between["N"] == pytest.approx((10, 1000**0.5))  # the table ends there


def test_a_step_that_begins_at_zero_is_open_to_its_middle_as_it_has_no_logarithm():
    rows = table(lambda rows: 1 + abs(rows["zeta_T"] - 1e-4) + rows["V_over_V0"])
    found = optimum(rows.assign(zeta_T=rows["zeta_T"].replace({1e-4: 0.0})))
    assert found.between["zeta_T"] == (0, 5e-3)


@pytest.mark.parametrize("status", ["step_budget", "pending", "unasked"])
def test_the_half_step_is_that_of_the_grid_whatever_became_of_the_rows_there(status):
    rows = table(status="done")
    rows.loc[(rows["N"] != 100) | (rows["M_over_M0"] != 1) | (rows["V_over_V0"] != 4), "status"] = status
    found = optimum(rows)
    assert found.between["N"] == pytest.approx((1000**0.5, 100))
    assert found.between["M_over_M0"] == pytest.approx((10**-0.5, 10**0.5))
    assert found.between["V_over_V0"] == pytest.approx((2**1.5, 2**2.5))


def test_where_chaotic_rows_are_left_out_the_half_step_is_that_of_the_grid():
    rows = table()
    found = optimum(rows.assign(chaotic=rows["V_over_V0"] != 2))
    assert found.between["V_over_V0"] == pytest.approx((2**0.5, 2**1.5))


def test_the_axes_tell_the_steps_that_a_table_lacks():
    """As of a shard, or of the candidates of a search whose neighbours have no row of their own."""
    rows = table(status="done").query("N == 100 and V_over_V0 == 4").copy()
    rows.loc[rows["M_over_M0"] != 1, "status"] = "unasked"
    which = {"chaotic_too": False, "over": ("N", "zeta_T"), "of": "ke_ratio", "among": ()}
    found = optimum_on({"V_over_V0": np.array([1.0, 4.0, 16.0]), "M_over_M0": np.array([1.0, 100.0])}, rows, **which)
    assert found.between["V_over_V0"] == pytest.approx((2, 8))
    assert found.between["N"] == (100, 100)
    assert found.between["M_over_M0"] == pytest.approx((1, 10)), "nobody looked at the steps between those of the axis"


@given(error=st.floats(0, 2), seed=st.integers(0, 99))
def test_larger_errors_never_narrow_an_interval(error, seed):
    ratio = np.random.default_rng(seed).uniform(0.1, 1, len(table()))
    sharp, vague = (optimum(table(lambda _: ratio, error=e)) for e in (error, 1.5 * error + 0.01))
    assert sharp.rivals <= vague.rivals
    assert vague.low <= sharp.low <= sharp.ke_ratio <= sharp.high <= vague.high
    for name, value in sharp.at.items():
        assert vague.between[name][0] <= sharp.between[name][0] <= value <= sharp.between[name][1]


def test_a_chaotic_optimum_is_as_wide_as_its_spread():
    rows = table(chaotic=True, spread_low=0.5, spread_high=7.0)
    found = optimum(rows)
    assert (found.low, found.high, found.chaotic, found.rivals) == (0.5, 7.0, True, len(rows) - 1)


@pytest.mark.parametrize("error", [np.nan, np.inf])
def test_an_error_that_says_nothing_gives_no_interval_and_hides_no_chaos(error):
    found = optimum(table(chaotic=True, error=error, checked=True))
    assert np.isnan([found.low, found.high]).all()
    assert found.rivals is None
    assert "(error not estimated, chaotic) at" in str(found)


def test_without_a_finished_row_there_is_no_optimum():
    with pytest.raises(InputError, match="no finished row has a ke_ratio"):
        optimum(table(status="error"))
