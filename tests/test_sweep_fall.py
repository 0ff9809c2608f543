"""The search for a fall, on made-up curves: it brackets what a dense grid would show, and asks for few N."""

import math
from itertools import pairwise

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from sweep.plan.fall import HIGH, Rule, lattice
from sweep.plan.line import Axis, Line
from sweep.plan.lines import wanted

START = (5, 8, 12, 19, 30, 48, 75, 120, 190, 300)
UNTILS = st.sampled_from([0.01, 0.02, 0.05, 0.2])
MANY = 10_000


def search(values, start, rule, given_rows=()):
    """Replay a sweep: all N that were asked for, ascending. `values`: over the lattice, nan where chaotic."""
    N = lattice(start, rule.until)
    line, places = Line(Axis(N), above=0.0), np.searchsorted(N, sorted(start)).tolist()
    line.known.update({k: float(values[k]) for k in given_rows})
    while new := wanted(line, places, rule):
        assert not line.known.keys() & set(new)
        line.known.update({k: float(values[k]) for k in new})
    return np.array(sorted(line.known))


def over_lattice(until, curve):
    N = np.array(lattice(START, until), float)
    return N, curve(N)


def last_crossing(N, values):
    """Of the points that tell something: the neighbours between which the curve falls below HIGH for the last time."""
    told = np.isfinite(values)
    N, values = N[told], values[told]
    k = np.flatnonzero(values[:-1] > HIGH)[-1]
    return N[k], N[k + 1], values[k], values[k + 1]


def is_narrow(low, high, until):
    return high <= (1 + until) * low or high == low + 1


@given(st.lists(st.integers(2, 10_000), min_size=3, max_size=20, unique=True), UNTILS)
def test_the_lattice_holds_the_start_and_is_as_fine_as_asked_for(start, until):
    values = lattice(start, until)
    assert values == sorted(set(values))
    assert set(start) <= set(values)
    assert values[0] == min(start)
    assert values[-1] == max(start)
    assert all(is_narrow(a, b, until) for a, b in pairwise(values))


@given(st.floats(5.0, 299.9), UNTILS)
def test_a_step_is_bracketed_by_bisection(place, until):
    N, values = over_lattice(until, lambda N: np.where(place >= N, 2.0, 0.1))
    asked = search(values, START, Rule("level", until, MANY))
    low, high, *_ = last_crossing(N[asked], values[asked])
    assert low <= place <= high
    assert is_narrow(low, high, until)
    cells = max(np.diff(np.searchsorted(N, START)))
    assert len(asked) - len(START) <= math.ceil(math.log2(cells))


@given(st.floats(10.0, 250.0), UNTILS, st.integers(0, 2**32 - 1))
def test_a_noisy_step_is_bracketed_where_it_crosses(place, until, seed):
    noise = 0.3 * np.random.default_rng(seed).standard_normal(len(lattice(START, until)))
    N, values = over_lattice(until, lambda N: (place / N) ** 4 * np.exp(noise))
    values[-1] = 0.1
    assume(values[0] > HIGH)
    asked = search(values, START, Rule("level", until, MANY))
    low, high, above, below = last_crossing(N[asked], values[asked])
    assert above > HIGH >= below
    assert is_narrow(low, high, until)


@given(UNTILS, st.sampled_from(["level", "log_slope"]), st.floats(0.01, 0.99) | st.floats(1.01, 9.0))
def test_where_nothing_falls_nothing_is_asked_for(until, find, value):
    _, values = over_lattice(until, lambda N: np.full(len(N), value))
    assert len(search(values, START, Rule(find, until, MANY))) == len(START)


@given(UNTILS, st.integers(0, 2**32 - 1), st.floats(1.0, 30.0))
def test_the_steepest_fall_of_a_falling_curve_is_the_dense_grid_s(until, seed, unevenness):
    """As long as no N between two that were asked for can hide a rise, nothing steeper is missed."""
    N = np.array(lattice(START, until), float)
    drops = np.random.default_rng(seed).random(len(N) - 1) ** unevenness
    log_ratio = 1.0 - 3.0 * np.append(0.0, np.cumsum(drops / drops.sum()))
    asked = search(np.exp(log_ratio), START, Rule("log_slope", until, MANY))
    steepest = (-np.diff(log_ratio) / np.diff(np.log(N))).max()
    found = (-np.diff(log_ratio[asked]) / np.diff(np.log(N[asked]))).max()
    assert math.isclose(found, steepest, rel_tol=1e-9)


@given(st.sampled_from(["level", "log_slope"]), st.integers(1, 60), st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_chaos_costs_a_bounded_number_of_tasks(find, most, share, seed):
    rng = np.random.default_rng(seed)
    N, values = over_lattice(0.01, lambda N: (90.0 / N) ** 3)
    values[rng.random(len(N)) < share] = np.nan
    asked = search(values, START, Rule(find, 0.01, most))
    assert len(asked) <= len(START) + most


def test_a_chaotic_stretch_is_approached_from_both_ends_in_few_steps():
    N, values = over_lattice(0.01, lambda N: (90.0 / N) ** 3)
    values[(N > 60) & (N < 200)] = np.nan
    asked = search(values, START, Rule("level", 0.01, MANY))
    low, high, *_ = last_crossing(N[asked], values[asked])
    assert (low, high) == (N[N <= 60][-1], N[N >= 200][0])
    assert len(asked) - len(START) <= 2 * math.ceil(math.log2(len(N)))


def test_a_fall_into_chaos_is_followed_as_far_as_one_can_see():
    """Beyond 150 nothing is told, but between 120 and there the curve has fallen."""
    N, values = over_lattice(0.02, lambda N: np.where(N <= 130, 2.0, 0.3))
    values[N > 150] = np.nan
    asked = search(values, START, Rule("level", 0.02, MANY))
    low, high, *_ = last_crossing(N[asked], values[asked])
    assert low <= 130 < high
    assert is_narrow(low, high, 0.02)


@given(st.integers(0, 2**32 - 1), st.sampled_from(["level", "log_slope"]))
def test_rows_that_were_not_asked_for_change_nothing(seed, find):
    """A reused table may hold any; the search must end in the same rows all the same."""
    rng, rule = np.random.default_rng(seed), Rule(find, 0.02, 50)
    _, values = over_lattice(0.02, lambda N: (90.0 / N) ** 3 * np.exp(0.2 * rng.standard_normal(len(N))))
    extra = np.flatnonzero(rng.random(len(values)) < 0.3)
    assert set(search(values, START, rule, extra)) == set(search(values, START, rule)) | set(extra.tolist())
