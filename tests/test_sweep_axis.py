"""An axis is a number, a list or a range; each gives distinct values that keep the task's rules."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.plan.axis import axis_values

POSITIVE = st.floats(0.01, 20)


def test_a_number_is_an_axis_of_one_value():
    assert axis_values("N", 7) == (7,)
    assert axis_values("zeta_T", 0) == (0.0,)


def test_minus_zero_is_zero():
    assert str(axis_values("zeta_T", [-0.0, 1.0])) == "(0.0, 1.0)"


@pytest.mark.parametrize("value", [200, 200.0, [200.0], {"linear": [200.0, 300.0], "points": 1}])
def test_two_hundred_cells_are_a_whole_number_however_they_are_written(value):
    assert axis_values("N", value) == (200,)
    assert type(axis_values("N", value)[0]) is int


def test_the_same_number_of_cells_written_twice_is_given_twice():
    with pytest.raises(ValueError, match=r"distinct values, got 200 more than once"):
        axis_values("N", [200, 200.0])


def test_a_list_keeps_the_order_given():
    assert axis_values("M_over_M0", [2, 0.5, 1.0]) == (2.0, 0.5, 1.0)


def test_a_linear_range_has_equal_steps_and_both_ends():
    assert axis_values("V_over_V0", {"linear": [1, 3], "points": 5}) == (1.0, 1.5, 2.0, 2.5, 3.0)


def test_a_log_range_has_equal_ratios_and_both_ends():
    assert axis_values("zeta_T", {"log": [1e-4, 1e-1], "points": 4}) == (1e-4, 1e-3, 1e-2, 1e-1)


def test_a_range_may_fall():
    assert axis_values("V_over_V0", {"linear": [3, 1], "points": 3}) == (3.0, 2.0, 1.0)


def test_a_range_of_one_point_is_its_first_end():
    assert axis_values("V_over_V0", {"log": [2, 5], "points": 1}) == (2.0,)


def test_a_range_of_N_is_rounded_to_distinct_whole_numbers():
    values = axis_values("N", {"log": [5, 8], "points": 20})
    assert values == (5, 6, 7, 8)
    assert all(type(v) is int for v in values)


@given(POSITIVE, POSITIVE, st.integers(2, 50), st.sampled_from(["log", "linear"]))
def test_a_range_is_monotonic_between_its_ends(a, b, points, spacing):
    if math.isclose(a, b, rel_tol=1e-6):
        return
    values = axis_values("V_over_V0", {spacing: [a, b], "points": points})
    assert len(values) == points
    assert values[0] == pytest.approx(a, rel=1e-11)
    assert values[-1] == pytest.approx(b, rel=1e-11)
    assert list(values) == sorted(values, reverse=a > b)


def test_wide_ranges_reach_both_ends_exactly():
    assert axis_values("M_over_M0", {"linear": [99.97, 1.9], "points": 2}) == (99.97, 1.9)
    assert axis_values("zeta_T", {"log": [1e-300, 10.0], "points": 2}) == (1e-300, 10.0)


@pytest.mark.parametrize(
    ("name", "value", "rule"),
    [
        ("N", 1, "must be a whole number from 2 to 10000, got 1"),
        ("N", 5.5, "must be a whole number from 2 to 10000, got 5.5"),
        ("N", True, "must be a whole number from 2 to 10000, got True"),
        ("N", "5", "must be a whole number from 2 to 10000, got '5'"),
        ("N", {"log": [1, 5], "points": 3}, "must be a whole number from 2 to 10000, got 1"),
        ("zeta_T", -1e-9, "must be a number from 0 to 10, got -1e-09"),
        ("zeta_T", math.nan, "must be a number from 0 to 10, got nan"),
        ("M_over_M0", 0, "must be a number from 0.01 to 100, got 0"),
        ("M_over_M0", [1, -2.0], "must be a number from 0.01 to 100, got -2.0"),
        ("V_over_V0", math.inf, "must be a number from 0.01 to 20, got inf"),
        ("V_over_V0", [], "must hold at least one value, got []"),
        ("V_over_V0", [1, 2, 1.0], "must hold distinct values, got 1 more than once"),
        ("V_over_V0", {}, "must be a number, a list, or a range"),
        ("V_over_V0", {"log": [1, 2]}, "must be a number, a list, or a range"),
        ("V_over_V0", {"log": [1, 2], "linear": [1, 2], "points": 2}, "must be a number, a list, or a range"),
        ("V_over_V0", {"log": [1, 2], "points": 2, "base": 10}, "must be a number, a list, or a range"),
        ("V_over_V0", {"log": [1, 2], "points": 0}, "points must be a whole number from 1 to 1000000, got 0"),
        ("V_over_V0", {"log": [1, 2], "points": 2.0}, "points must be a whole number from 1 to 1000000, got 2.0"),
        ("V_over_V0", {"log": [1, 2], "points": 10**9}, "points must be a whole number from 1 to 1000000"),
        ("V_over_V0", {"log": [0, 2], "points": 2}, "log needs both ends above 0, got [0, 2]"),
        ("V_over_V0", {"log": [1, math.nan], "points": 2}, "log must be two finite numbers [a, b], got [1, nan]"),
        ("V_over_V0", {"linear": [1, 2, 3], "points": 2}, "linear must be two finite numbers [a, b], got [1, 2, 3]"),
        ("V_over_V0", {"linear": [2, 2], "points": 3}, "linear needs two different ends, got [2, 2]"),
    ],
)
def test_a_bad_axis_is_refused_with_rule_and_value(name, value, rule):
    with pytest.raises(ValueError, match=r"must|needs") as caught:
        axis_values(name, value)
    assert rule in str(caught.value)


def test_every_bad_value_of_a_list_is_named():
    with pytest.raises(ValueError, match=r"^must be a number from 0.01 to 100, got -1, -2$"):
        axis_values("M_over_M0", [1, -1, -2])


def test_a_million_coinciding_points_are_refused_at_once():
    with pytest.raises(ValueError, match="distinct"):
        axis_values("V_over_V0", {"linear": [1, 1.0000000001], "points": 1_000_000})


def test_a_mistyped_key_of_a_range_is_hinted_at():
    with pytest.raises(ValueError, match=r"\(did you mean 'points'\?\)$"):
        axis_values("N", {"log": [5, 200], "point": 8})


def test_a_rule_that_many_values_of_a_range_break_is_told_once():
    with pytest.raises(ValueError, match="must be") as caught:
        axis_values("V_over_V0", {"log": [0.1, 1000], "points": 5})
    assert str(caught.value) == "must be a number from 0.01 to 20, got 100.0, 1000.0"
