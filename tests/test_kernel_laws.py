"""Every spring law tells one story: force, energy, stiffness, its bound and its barrier agree, packed and alone."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from kernel.elementary import growth, power
from kernel.jit import jit
from kernel.laws import SPRINGS, Bistable, PiecewiseLinear, Polynomial, PowerLaw, Toda
from kernel.laws.any_power import AnyPower
from kernel.laws.hertz import ThreeHalves
from kernel.simd import load, load_sixteen, store, width

strains = st.floats(-1.5, 1.5)
laws = st.one_of(
    st.builds(Bistable, st.floats(-5, 8), st.floats(0.1, 10)),
    st.builds(Polynomial, st.floats(-5, 5), st.floats(0, 10)),
    st.builds(Toda, st.floats(1e-3, 4)),
    st.builds(PowerLaw, st.floats(1, 4), st.sampled_from([0.0, 1e-3, 0.1, 2.0])),
    st.builds(
        lambda s, k: PiecewiseLinear(tuple(np.cumsum(s)), tuple(k)),
        st.lists(st.floats(0.05, 0.5), min_size=3, max_size=3),
        st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.1, 5)),
    ),
)


def tension(law, e):
    return float(e + law.excess(e))


def kinks(law):
    """Where force or stiffness are not smooth."""
    if isinstance(law, PiecewiseLinear):
        return tuple(-s for s in law.strains)
    return (law.precompression,) if isinstance(law, PowerLaw) else (0.0,)


@given(laws, strains)
def test_energy_is_the_integral_of_the_tension(law, e):
    inside = [x for x in kinks(law) if min(e, 0.0) < x < max(e, 0.0)] or None
    true, _ = quad(lambda x: tension(law, x), 0.0, e, points=inside, epsabs=1e-13, limit=200)
    assert law.energy_at(e) == pytest.approx(true, rel=1e-9, abs=1e-12)


@given(laws, strains)
def test_stiffness_is_the_slope_of_the_tension(law, e):
    if min(abs(e - x) for x in kinks(law)) < 1e-4:
        return
    h = 1e-6
    scale = max(1.0, law.steepest(e - h, abs(e) + h))
    slope = (tension(law, e + h) - tension(law, e - h)) / (2 * h)
    assert law.stiffness_at(e) == pytest.approx(slope, rel=1e-4, abs=1e-5 * scale)


@given(laws, st.floats(-1.5, 0.0), st.floats(0.0, 1.5))
def test_no_strain_between_two_is_stiffer_than_the_steepest(law, lowest, highest):
    top = law.steepest(lowest, highest if law.stiffens_in_tension() else 0.0)
    for e in np.linspace(lowest, highest, 60):
        assert law.stiffness_at(float(e)) <= top * (1 + 1e-12)


@given(laws)
def test_at_rest_the_stiffness_is_one_as_that_of_the_linear_chain(law):
    if isinstance(law, PowerLaw) and not law.has_sound():
        return
    assert law.stiffness_at(0.0) == pytest.approx(1.0)
    assert law.excess(0.0) == pytest.approx(0.0, abs=1e-15)


@given(laws)
@example(Polynomial(8.4e-141, 0.0))
@example(Polynomial(5e-324, 0.0))
def test_the_barrier_is_the_first_place_beside_rest_where_a_link_holds_itself(law):
    barrier = law.barrier()
    side = 1.0 if barrier > 0 else -1.0
    grid = side * np.linspace(1e-3, 20.0, 20001)
    force = np.array([side * tension(law, float(e)) for e in grid])
    (below,) = np.nonzero(force < -1e-9)
    if np.isnan(barrier):
        assert not len(below) or isinstance(law, Polynomial | Bistable)  # a double zero within rounding
    else:
        # No term of the force is above twice the strain there; of one beyond 1e100 the square is beyond every float.
        assert abs(barrier) > 1e100 or abs(tension(law, barrier)) < 1e-7 * max(1.0, abs(barrier))
        assert not len(below) or abs(grid[below[0]]) >= abs(barrier) - 2e-3


@pytest.mark.parametrize(
    ("law", "keys"),
    [
        (Bistable(1.0, 0.0), {"c3"}),
        (Bistable("a", -1.0), {"c2", "c3"}),
        (Polynomial(float("nan"), -1.0), {"c2", "c3"}),
        (Toda(0.0), {"b"}),
        (PowerLaw(0.5, -1.0), {"exponent", "precompression"}),
        (PiecewiseLinear((), (1.0,)), {"strains"}),
        (PiecewiseLinear((0.2, 0.1), (1.0, -1.0)), {"strains", "slopes[1]"}),
        (PiecewiseLinear((0.2, 0.3), (1.0,)), {"strains, slopes"}),
        (PiecewiseLinear((0.2, 0.1), (0.0,)), {"strains, slopes", "strains", "slopes[0]"}),
        (PiecewiseLinear((0.2,), (1e-7,)), {"slopes[0]"}),
    ],
)
def test_every_broken_number_of_a_law_is_named_with_its_rule_and_value(law, keys):
    lines = law.problems()
    assert {line.partition(":")[0] for line in lines} == keys
    assert all("must" in line and "got" in line for line in lines)
    assert not [line for kind in SPRINGS.values() if kind is not PiecewiseLinear for line in kind().problems()]


def test_no_precompression_is_named_as_what_a_scene_alone_may_have():
    """A spec was told that it "must be 0, or", and then refused 0."""
    (line,) = PowerLaw(1.5, -1.0).problems()
    assert line == "precompression: must be a number from 1e-06 to 100, in a scene also 0, got -1.0"


def test_both_ends_of_a_range_are_in_it():
    assert PiecewiseLinear((1e-6, 100.0), (-1000.0, 1000.0)).problems() == []
    assert PiecewiseLinear((1e-6,), (1e-6,)).problems() == []


@pytest.mark.parametrize(
    ("law", "linear"),
    [
        (Bistable(0.0, 0.0), True),
        (Bistable(0.0, 1.0), False),
        (Polynomial(0.0, 0.0), True),
        (Polynomial(1.0, 0.0), False),
        (Polynomial(0.0, 1.0), False),
        (PiecewiseLinear((0.1, 0.2), (1.0, 1.0)), True),
        (PiecewiseLinear((0.1, 0.2), (1.0, 2.0)), False),
    ],
)
def test_a_law_is_linear_where_its_tension_is_the_strain(law, linear):
    assert law.is_linear() is linear
    assert linear == all(tension(law, float(e)) == e for e in np.linspace(-1, 1, 21))


@pytest.mark.parametrize(
    ("law", "jumps"),
    [
        (Bistable(), False),
        (Polynomial(1.0, 2.0), False),
        (Toda(2.0), False),
        (PowerLaw(1.5, 0.1), False),
        (PowerLaw(1.0, 0.1), True),
        (PowerLaw(1.0, 0.0), True),
        (PiecewiseLinear((0.1, 0.2), (1.0, 1.0)), False),
        (PiecewiseLinear((0.1, 0.2), (1.0, 2.0)), True),
    ],
)
def test_a_law_says_whether_its_stiffness_jumps_at_a_kink(law, jumps):
    assert law.stiffness_jumps() is jumps
    assert jumps == any(abs(law.stiffness_at(x + 1e-15) - law.stiffness_at(x - 1e-15)) > 1e-3 for x in kinks(law))


def test_a_softening_pieces_barrier_is_where_its_line_crosses_zero():
    law = PiecewiseLinear((0.1, 0.5), (-0.5, 2.0))
    assert law.barrier() == pytest.approx(brentq(lambda e: tension(law, e), -0.45, -0.12))


stiffnesses = st.floats(1.0, 1e6)
contacts = st.one_of(st.builds(AnyPower, stiffnesses, st.floats(1.0, 3.0)), st.builds(ThreeHalves, stiffnesses))


@given(contacts, st.floats(1e-4, 1.0))
def test_a_contact_of_any_powers_force_is_the_slope_of_its_energy_and_its_stiffness_that_of_its_force(law, d):
    h = 1e-5 * d
    assert (law.energy_at(d + h) - law.energy_at(d - h)) / (2 * h) == pytest.approx(law.push(d), rel=1e-6)
    assert (law.push(d + h) - law.push(d - h)) / (2 * h) == pytest.approx(law.stiffness_at(d), rel=1e-6)
    assert law.push(-d) == law.energy_at(-d) == 0.0
    assert law.at_unit_speed(2.0).push(d) == pytest.approx(law.push(2.0 * d) / 2.0)


overlaps = st.builds(lambda sign, size: sign * size, st.sampled_from([-1.0, 0.0, 1.0]), st.floats(1e-8, 1.0))


@given(contacts, overlaps, overlaps, st.floats(1e-8, 1e-2))
@example(AnyPower(1e3, 1.7), 0.1, 0.100001, 1e-8)  # both ends of a step are close
@example(AnyPower(1e3, 1.7), 0.01, -0.1, 1e-3)  # the bodies part
@example(ThreeHalves(1e3), 0.01, -0.1, 1e-3)
@example(ThreeHalves(1e3), 0.01, 0.01, 1e-3)  # they hardly move
def test_a_contact_of_any_power_gives_back_the_energy_that_it_took(law, d0, free, softness):
    d1, push = law.impulse(d0, free, softness)
    size = max(abs(d0), abs(free))
    assert d1 == pytest.approx(free - softness * push, rel=1e-9, abs=1e-12 * size)
    gained, resolved = law.energy_at(d1) - law.energy_at(d0), 1e-8 * size / softness
    assert abs(push * (d1 - d0) - gained) <= 1e-7 * abs(gained) + resolved * abs(d1 - d0)
    assert push >= -resolved


@given(contacts, st.floats(1e-6, 1.0), st.floats(1e-8, 1.0))
def test_an_overlap_and_what_its_force_gives_way_make_up_the_free_one(law, free, softness):
    x = law.overlap(free, softness, 0.5 * free)
    assert x + softness * law.push(x) == pytest.approx(free, rel=1e-9)
    assert law.overlap(0.0, softness, 0.5) == law.overlap(-free, softness, 0.5) == 0.0


def test_the_duration_of_hertzs_impact_is_that_of_the_paper_s_law():
    assert AnyPower(3e4, 1.5).duration(1.7, 0.3) == pytest.approx(ThreeHalves(3e4).duration(1.7, 0.3), rel=1e-3)
    assert AnyPower(3e4, 1.5).period(0.6, 0.01) == pytest.approx(ThreeHalves(3e4).period(0.6, 0.01))


@jit
def of_a_line(law, x, out):
    for i in range(0, x.shape[0], width(x)):
        store(out, i, law.excess(load(x, i)))


@jit
def of_sixteen(law, x, out):
    for i in range(0, x.shape[0], 16):
        store(out, i, law.excess(load_sixteen(x, i)))


@jit
def packed_functions(x, n, grown, raised):
    for i in range(0, x.shape[0], 8):
        store(grown, i, growth(load(x, i)))
        store(raised, i, power(load(x, i), n))


@pytest.mark.slow
@pytest.mark.parametrize("law", [Bistable(), Polynomial(1.0, 2.0), Toda(3.0), PowerLaw(1.5, 0.1), PowerLaw(2.3, 0.0)])
def test_packed_strains_have_the_tensions_of_each(law):
    x, out = np.linspace(-1.0, 1.0, 1600), np.empty(1600)
    of_a_line(law, x, out)
    np.testing.assert_allclose(out, [law.excess(float(e)) for e in x], rtol=1e-12, atol=1e-14)
    of_sixteen(law, x, out)
    np.testing.assert_allclose(out, [law.excess(float(e)) for e in x], rtol=1e-12, atol=1e-14)
    single = np.empty(1600, np.float32)
    for packed in (of_a_line, of_sixteen):
        packed(law, x.astype(np.float32), single)
        np.testing.assert_allclose(single, [law.excess(float(np.float32(e))) for e in x], rtol=1e-5, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("n", [1.0, 1.3, 1.5, 7.0])
def test_packed_powers_and_exponentials_are_right_to_some_last_places(n):
    x = np.concatenate([10.0 ** np.random.default_rng(1).uniform(-12, 2, 7992), np.zeros(8)])
    grown, raised = np.empty(8000), np.empty(8000)
    packed_functions(x, n, grown, raised)
    np.testing.assert_allclose(grown, np.expm1(x), rtol=1e-15)
    np.testing.assert_allclose(raised, x**n, rtol=3e-14, atol=1e-299)
    strange = np.array([np.nan, 800.0, 1e5, 0.0, 1.0, np.nan, 2.0, 3.0])
    packed_functions(strange, n, grown[:8], raised[:8])
    assert np.isnan(grown[:8]).tolist() == np.isnan(raised[:8]).tolist() == np.isnan(strange).tolist()


@pytest.mark.parametrize("x", [1e-9, 1e-5, 3e-4, 0.999e-3, 1.001e-3, 5e-3])
@pytest.mark.parametrize(("n", "d"), [(1.5, 100.0), (10.0, 1e-6), (1.0, 0.1)])
def test_the_energy_of_grains_that_are_hardly_pressed_keeps_its_digits(x, n, d):
    """Half of the strain squared, and what the law's own series adds: told exactly by Fraction."""
    for e in (x * d, -x * d):
        share = Fraction(e) / Fraction(d)
        series, term = Fraction(1, 2), Fraction(1, 2)
        for k in range(8):
            term *= -share * (Fraction(n) - 1 - k) / (k + 3)
            series += term
        assert PowerLaw(n, d).energy_at(e) == pytest.approx(float(series) * e * e, rel=2e-10, abs=0.0)


@pytest.mark.parametrize("x", [1e-9, 1e-3, 0.0499, 0.0501, 0.3])
def test_the_energy_of_todas_link_near_rest_keeps_its_digits(x):
    """Half of the strain squared, and the series that follows: told exactly by Fraction."""
    for e in (x / 3.0, -x / 3.0):
        strain = Fraction(e)
        series = sum((-3 * strain) ** k / factorial(k + 2) for k in range(20))
        assert Toda(3.0).energy_at(e) == pytest.approx(float(series * strain**2), rel=2e-14, abs=0.0)


def test_a_force_that_touches_zero_and_turns_back_has_its_barrier_there():
    assert PiecewiseLinear((0.1, 0.3), (-0.5, 2.0)).barrier() == pytest.approx(-0.3)
