"""Cells of a map lie where their values are, and round numbers stand beside them without running into each other."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.colours import plain_scale, ratio_scale
from analysis.ruler import ruler
from analysis.style import plain_ticks
from analysis.ticks import label, labels, linear, scale_ticks, ticks

SIDE = 2.6  # inches


def test_cells_reach_half_way_in_the_logarithm_of_uneven_values():
    np.testing.assert_allclose(ruler(np.array([1.0, 100, 1000])).borders, [0.1, 10, 10**2.5, 10**3.5])


def test_the_cells_of_an_adaptive_line_are_as_wide_as_their_gaps():
    uneven = ruler(np.array([10.0, 32, 56, 91, 170, 1000]))
    assert uneven.log
    widths = np.diff(np.log(uneven.cells), axis=1)[:, 0]
    assert widths[-1] > 3 * widths[2]
    np.testing.assert_allclose(uneven.cells[1:, 0], uneven.cells[:-1, 1])


def test_evenly_spaced_values_have_an_even_axis():
    even = ruler(np.arange(5.0, 505, 5))
    assert not even.log
    np.testing.assert_allclose(np.diff(even.borders), 5)
    assert not ruler(np.array([0.0, 1e-3, 2e-3])).log
    assert ruler(np.unique(np.geomspace(5, 200, 30).round())).log


def test_a_zero_has_a_cell_of_its_own_apart_from_the_smallest_positive_value():
    damping = ruler(np.r_[0, np.logspace(-3, 0, 31)])
    zero, first = damping.cells[:2]
    assert damping.gap
    assert zero[0] < damping.place(0) < zero[1] < first[0] < 1e-3 < first[1]
    assert np.log(zero[1] / zero[0]) == pytest.approx(np.log(first[1] / first[0]))
    assert 0 < damping.share(0) < damping.share(1e-3) < damping.share(1) < 1


def test_a_matrix_gets_an_empty_strip_where_the_gap_is():
    cells = ruler(np.array([0, 1e-3, 1e-1])).spread(np.array([[1.0, 2, 3]]), axis=1)
    np.testing.assert_array_equal(cells, [[1, np.nan, 2, 3]])


def test_logarithmic_grid_is_labelled_at_its_decades():
    marks = ticks(ruler(np.logspace(-5, 0, 51)), SIDE, across=False)
    assert marks.labels == ["$10^{-5}$", "$10^{-4}$", "$10^{-3}$", "0.01", "0.1", "1"]
    assert marks.places == [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1]
    assert marks.minor[:10] == pytest.approx([k * 1e-5 for k in (*range(1, 10), 10)])


def test_zero_is_labelled_and_what_would_run_into_it_is_not():
    damping = ruler(np.r_[0, np.logspace(-5, 0, 51)])
    marks = ticks(damping, SIDE, across=False)
    assert marks.labels[0] == "0"
    places = [damping.share(value) * SIDE for value in marks.places]
    assert np.diff(places).min() > 0.15


def test_even_grid_is_labelled_at_even_steps():
    assert ticks(ruler(np.arange(5.0, 505, 5)), SIDE, across=True).labels == ["100", "200", "300", "400", "500"]


def test_many_values_that_few_round_ones_lie_among_are_labelled_at_finer_round_ones():
    many = ruler(np.linspace(4.0137, 5.4863, 40))
    assert ticks(many, SIDE, across=False).labels == ["4.2", "4.4", "4.6", "4.8", "5", "5.2", "5.4"]


def test_short_list_carries_each_value_where_there_is_room():
    damping = ruler(np.array([0, 4e-5, 4e-4]))
    assert ticks(damping, SIDE, across=True).labels == ["0", r"$4{\times}10^{-5}$", r"$4{\times}10^{-4}$"]
    assert ticks(damping, SIDE, across=True).minor == []
    few = ticks(damping, 0.5, across=True)
    assert len(few.labels) < 3
    assert few.minor


NUMBERS = st.just(0.0) | st.floats(1e-12, 1e6).map(lambda value: float(f"{value:.9g}"))


@given(
    values=st.lists(NUMBERS, min_size=1, max_size=60, unique=True),
    inches=st.floats(0.4, 5),
    across=st.booleans(),
)
def test_any_list_of_values_gets_ticks_on_the_map(values, inches, across):
    axis = ruler(np.sort(values))
    marks = ticks(axis, inches, across)
    assert len(marks.places) == len(marks.labels) >= 1
    assert (np.diff(axis.borders) > 0).all()
    assert all(0 <= axis.share(value) <= 1 for value in [*marks.places, *marks.minor])


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (5.0, "5"),
        (500.0, "500"),
        (1234.0, "1234"),
        (999.7, "1000"),
        (0.0099996, "0.01"),
        (9999.9, "$10^{4}$"),
        (0.25, "0.25"),
        (2e-3, r"$2{\times}10^{-3}$"),
    ],
)
def test_label_is_short(value, text):
    assert label(value) == text


def test_a_scale_is_labelled_with_plain_round_numbers():
    assert scale_ticks(1e-3, 1) == [1e-3, 1e-2, 1e-1, 1]
    assert scale_ticks(20.175, 60) == linear(20.175, 60) == [30, 40, 50, 60]
    assert scale_ticks(0.5625, 1.97) == linear(0.5625, 1.97) == [0.6, 0.8, 1, 1.2, 1.4, 1.6, 1.8]


@given(st.floats(0.02, 50), st.floats(1.1, 20))
def test_the_bar_of_a_ratio_has_three_numbers_however_near_to_1_the_ratios_are(low, span):
    scale = ratio_scale(np.array([low, low * span]))
    seen = [tick for tick in scale.ticks if scale.shown[0] <= tick <= scale.shown[1]]
    assert len(seen) >= 3
    assert {label(tick) for tick in seen} >= {"1"}
    assert len({label(tick) for tick in seen}) == len(seen)


@given(
    numbers=st.lists(st.floats(1e-6, 1e4), min_size=1, max_size=8),
    inches=st.floats(0.5, 4),
    scale_of=st.sampled_from([ratio_scale, plain_scale]),
)
def test_numbers_beside_a_bar_of_any_height_have_room(numbers, inches, scale_of):
    scale = scale_of(np.array(numbers))
    seen = scale.labelled(inches)
    places = (scale.norm(np.array(seen)) - scale.norm(scale.shown[0])) / np.ptp(scale.norm(np.array(scale.shown)))
    assert (np.diff(places) * inches > 0.15).all()  # inches; a label is as high as its font, 9 points
    assert (places >= -1e-9).all()
    assert (places <= 1 + 1e-9).all()
    if scale_of is ratio_scale and scale.shown[0] <= 1 <= scale.shown[1]:
        assert 1 in seen


@pytest.mark.parametrize("limits", [(0.1, 10.0), (1e-120, 10.0), (1e-12, 1e305)])
def test_the_numbers_beside_a_bar_take_one_call_of_its_scale_however_long_it_is(limits):
    scale, calls = ratio_scale(np.array([0.5, 2.0]), limits), []
    seen = replace(scale, norm=lambda values: calls.append(values) or scale.norm(values)).labelled(2.5)
    assert (len(calls), len(seen) >= 3) == (1, True)


def test_a_bar_whose_values_lie_in_two_crowds_is_labelled_between_them():
    crowds = plain_scale(np.array([0.0414, 0.0459, 0.0541, 0.541, 0.671, 0.831]))
    assert crowds.labelled(1.7) == [0.05, 0.1, 0.2, 0.5]
    assert plain_scale(np.array([0.5, 1, 2])).labelled(1.7) == [0.5, 1, 2]


@given(st.floats(1e-4, 1e4), st.floats(1.1, 1e5))
def test_every_logarithmic_axis_has_labels_to_read_a_number_between(low, times):
    from matplotlib.figure import Figure

    ax = Figure().subplots()
    ax.set(yscale="log", ylim=(low, low * times))
    plain_ticks(ax.yaxis)
    seen = [tick for tick in ax.yaxis.get_majorticklocs() if low <= tick <= low * times]
    assert 2 <= len(seen) <= 12


def test_values_that_differ_late_are_labelled_differently():
    """As of a grid about one impact; before, all three were 1."""
    assert ticks(ruler(np.array([1.0001, 1.0002, 1.0003])), SIDE, across=True).labels == ["1.0001", "1.0002", "1.0003"]
    tiny = ticks(ruler(np.array([1e-3, 1.0001e-3, 1.0002e-3])), SIDE, across=False).labels
    assert tiny == ["$10^{-3}$", r"$1.0001{\times}10^{-3}$", r"$1.0002{\times}10^{-3}$"]


@given(st.lists(st.floats(1e-6, 1e6), min_size=1, max_size=8, unique=True))
def test_no_two_values_have_one_label(values):
    assert len(set(labels(values))) == len(values)
