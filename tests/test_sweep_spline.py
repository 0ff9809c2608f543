"""What lies between the computed places of a map is scipy's thin-plate spline, and is told only where it is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import RBFInterpolator

from sweep.plan import spline
from sweep.plan.spline import coordinates, first_places, interpolated, left_out, rough_places, wanted

SHAPE = (20, 17)
AT = coordinates([np.geomspace(1, 50, SHAPE[0]), np.linspace(0, 3, SHAPE[1])])


def hilly(at):
    return np.sin(at[:, 0] / 3) * np.cos(at[:, -1] / 4)


def thin_plate(at, logs):
    return RBFInterpolator(at, logs, neighbors=spline.THROUGH, kernel="thin_plate_spline", degree=1)


def test_the_spline_is_that_of_scipy_also_where_each_place_is_left_out():
    rng = np.random.default_rng(1)
    at = rng.uniform(0, 20, (60, 2))
    computed, logs = np.arange(60) < 40, hilly(at)
    found = interpolated(at, logs, computed)
    assert found[40:] == pytest.approx(thin_plate(at[:40], logs[:40])(at[40:]), abs=1e-6)
    assert found[:40] == pytest.approx(logs[:40], abs=1e-6)
    for k in range(5):
        others = np.arange(40) != k
        alone = thin_plate(at[:40][others], logs[:40][others])(at[k : k + 1])[0]
        assert left_out(at[:40], logs[:40])[k] == pytest.approx(abs(alone - logs[k]), abs=1e-6)


def test_splines_solved_in_parts_are_those_solved_at_once(monkeypatch):
    computed = np.random.default_rng(1).random(len(AT)) < 0.3
    once = interpolated(AT, hilly(AT), computed)
    monkeypatch.setattr(spline, "AT_ONCE", 7)
    assert interpolated(AT, hilly(AT), computed) == pytest.approx(once, abs=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_a_power_law_is_interpolated_exactly(seed):
    rng = np.random.default_rng(seed)
    at = coordinates([np.sort(rng.lognormal(size=n)).tolist() for n in rng.integers(9, 20, size=2)])
    logs = at @ rng.normal(size=2) + rng.normal()
    assert interpolated(at, logs, rng.random(len(at)) < 0.5) == pytest.approx(logs, abs=1e-5)


@given(st.integers(0, 2**32 - 1), st.lists(st.integers(1, 12), min_size=1, max_size=3))
def test_any_map_with_any_places_computed_is_told_somewhere_and_asks_only_for_what_is_not_computed(seed, shape):
    rng = np.random.default_rng(seed)
    at = coordinates([np.sort(rng.lognormal(size=n)).tolist() for n in shape])
    logs, computed = np.where(rng.random(len(at)) < 0.2, np.nan, rng.normal(size=len(at))), rng.random(len(at)) < 0.3
    computed[first_places(shape)] = True
    known = computed & np.isfinite(logs)
    found = interpolated(at, logs, computed)
    assert np.isfinite(found).any() == known.any()
    asked = wanted(at, logs, computed, 0.1, 5)
    assert len(asked) == len({*asked.tolist()}) <= 5
    assert not computed[asked].any()


def test_amid_places_that_are_worth_nothing_nothing_is_told_nor_asked_for():
    logs = np.where(AT[:, 0] < 9.5, np.nan, 3 * np.sin(5 * AT[:, 0] * AT[:, 1]))
    computed = np.zeros(len(AT), np.bool_)
    computed[first_places(SHAPE)] = True
    far = AT[:, 0] < 2
    assert np.isnan(interpolated(AT, logs, computed)[far]).all()
    asked = wanted(AT, logs, computed, 0.01, 100)
    assert len(asked) > 0
    assert not far[asked].any()


def test_the_first_places_hold_both_ends_of_every_axis_and_leave_no_gap_wider_than_a_step():
    for shape in [(1,), (2, 9), (17, 18), (50, 3, 1)]:
        places = np.unravel_index(first_places(shape), shape)
        for n, place in zip(shape, places, strict=True):
            assert {0, n - 1} <= {*place.tolist()}
            assert np.diff(np.unique(place)).max(initial=0) <= spline.FIRST_STEP


def test_coordinates_are_those_of_the_logarithm_where_an_axis_has_no_zero():
    assert coordinates([[1, 10, 100]])[:, 0] == pytest.approx([0, 1, 2])
    assert coordinates([[0, 10, 100]])[:, 0] == pytest.approx([0, 0.2, 2])
    assert coordinates([[7.0], [1, 2]]).tolist() == [[0, 0], [0, 1]]


@given(st.integers(0, 2**32 - 1))
def test_rough_places_lie_where_it_is_rough_and_none_is_computed_twice(seed):
    rng = np.random.default_rng(seed)
    logs, computed = np.add.outer(np.arange(30.0), np.arange(20.0)), rng.random(600) < 0.1
    assert not len(rough_places(logs, computed))  # a plain
    logs[:, 12:] += rng.normal(size=(30, 8))
    logs[rng.random((30, 20)) < 0.05] = np.nan  # screening failed
    places = rough_places(logs, computed)
    assert 1 <= len(places) <= round(spline.ROUGH * 600)
    assert not computed[places].any()
    assert (places % 20 >= 11).all()


def test_of_a_map_that_is_rough_all_over_a_share_is_computed_first_in_no_half_of_it_much_more():
    places = rough_places(np.random.default_rng(3).normal(size=(100, 100)), np.zeros(10_000, np.bool_))
    assert len(places) == round(spline.ROUGH * 10_000)
    assert np.mean(places < 5_000) == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(("known", "asks"), [(1, False), (2, True)])
def test_two_computed_numbers_are_the_fewest_that_show_where_to_look_next(known, asks):
    computed = np.arange(len(AT)) < known
    asked = wanted(AT, np.where(computed, 10.0 * np.arange(len(AT)), np.nan), computed, 0.1, 5)
    assert (len(asked) > 0) == asks
