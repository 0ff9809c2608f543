"""Claims about the labels beside a map."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.ticks import label, ticks


def test_logarithmic_grid_is_labelled_at_its_decades():
    marks = ticks(np.logspace(-5, 0, 51))
    assert marks.labels == ["$10^{-5}$", "$10^{-4}$", "$10^{-3}$", "0.01", "0.1", "1"]
    np.testing.assert_allclose(marks.positions, [0, 10, 20, 30, 40, 50], atol=1e-6)


def test_zero_stands_below_the_smallest_positive_value():
    marks = ticks(np.r_[0, np.logspace(-3, 0, 31)])
    assert marks.labels[0] == "0"
    assert marks.positions[0] == 0
    assert marks.positions[-1] == 31
    assert min(marks.minor) >= 1


def test_even_grid_is_labelled_at_even_steps():
    marks = ticks(np.arange(5.0, 505, 5))
    assert marks.labels == ["100", "200", "300", "400", "500"]
    np.testing.assert_allclose(marks.positions, [19, 39, 59, 79, 99])


def test_short_list_carries_each_value():
    assert ticks(np.array([0, 4e-5, 4e-4])).labels == ["0", r"$4{\times}10^{-5}$", r"$4{\times}10^{-4}$"]


@given(st.lists(st.floats(0, 1e6, allow_subnormal=False), min_size=1, max_size=60, unique=True))
def test_any_list_of_values_gets_ticks_on_the_map(values):
    marks = ticks(np.sort(values))
    assert len(marks.positions) == len(marks.labels) >= 1
    assert all(0 <= place <= len(values) - 1 for place in [*marks.positions, *marks.minor])


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (5.0, "5"), (500.0, "500"), (1234.0, "1234"), (0.25, "0.25"), (2e-3, r"$2{\times}10^{-3}$")],
)
def test_label_is_short(value, text):
    assert label(value) == text
