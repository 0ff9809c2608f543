"""The compiled physics equals its plain-Python twin, and its forces are the slopes of its energies."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kernel import model, stages, state
from kernel.jit import jit
from kernel.laws.bistable import Bistable
from kernel.laws.hertz import ThreeHalves
from kernel.task import M0, V0

from . import twin

numbers = st.floats(-3.0, 3.0)
laws = st.sampled_from([Bistable(), Bistable(0.0, 0.0)])


@jit
def of_spring(law, e):
    return model.tension(law, e), law.energy_at(e), law.stiffness_at(e)


@jit
def of_contact(law, d):
    return law.push(d), law.energy_at(d), law.stiffness_at(d)


@st.composite
def chains_in_motion(draw):
    N = draw(st.integers(2, 12))
    zeta_T = draw(st.sampled_from([0.0, 1e-3, 1.0]))
    chain = model.make_chain(N, zeta_T, draw(st.floats(0.1, 10)), bistable=draw(st.booleans()))
    state = arrays(np.float64, N + 1, elements=numbers)
    return chain, draw(state), draw(state)


@given(laws, numbers)
def test_a_compiled_spring_equals_its_twin_and_itself_in_plain_python(law, e):
    force, energy, stiffness = of_spring(law, e)
    assert force == pytest.approx(twin.spring_force(*law, e), rel=1e-13, abs=1e-15)
    assert energy == pytest.approx(twin.spring_energy(*law, e), rel=1e-13, abs=1e-15)
    plain = e + law.excess(e), law.energy_at(e), law.stiffness_at(e)
    assert (force, energy, stiffness) == pytest.approx(plain, rel=1e-13, abs=1e-15)


@given(st.floats(-1.0, 1.0), st.floats(1.0, 1e6))
def test_a_compiled_contact_equals_its_twin_and_never_pulls(overlap, K):
    force, energy, _ = of_contact(ThreeHalves(K), overlap)
    assert force == pytest.approx(twin.contact_force(K, overlap), rel=1e-13)
    assert energy == pytest.approx(twin.contact_energy(K, overlap), rel=1e-13)
    assert of_contact(ThreeHalves(K), -abs(overlap))[:2] == (0.0, 0.0)


@given(laws, numbers.filter(lambda e: abs(e) > 1e-4))
def test_a_springs_force_is_the_slope_of_its_energy_and_its_stiffness_that_of_its_force(law, e):
    h = 1e-5
    (f0, E0, _), (f, _, stiffness), (f1, E1, _) = (of_spring(law, x) for x in (e - h, e, e + h))
    assert (E1 - E0) / (2 * h) == pytest.approx(f, rel=1e-6, abs=1e-6)
    assert (f1 - f0) / (2 * h) == pytest.approx(stiffness, rel=1e-6, abs=1e-6)


@given(laws, st.floats(-2.0, 0.0), st.floats(0.0, 2.0))
def test_no_strain_between_two_is_stiffer_than_the_steepest(law, lowest, highest):
    assert np.all(law.stiffness_at(np.linspace(lowest, highest, 100)) <= law.steepest(lowest, highest) * (1 + 1e-12))


@given(st.floats(1e-3, 1.0))
def test_a_contacts_force_is_the_slope_of_its_energy_and_its_stiffness_that_of_its_force(overlap):
    h = 1e-7
    (f0, E0, _), (f, _, stiffness), (f1, E1, _) = (
        of_contact(ThreeHalves(7.0), d) for d in (overlap - h, overlap, overlap + h)
    )
    assert (E1 - E0) / (2 * h) == pytest.approx(f, rel=1e-5)
    assert (f1 - f0) / (2 * h) == pytest.approx(stiffness, rel=1e-5)


@given(chains_in_motion())
def test_acceleration_energy_and_dissipation_equal_their_twins(scene):
    chain, u, v = scene
    s = state.new_state(chain.N, v[0])
    s.u[: chain.N], s.v[: chain.N], s.impactor[0] = u[1:], v[1:], u[0]
    n, no_size = state.padded(chain.N), 0.0  # every stage is at the state itself
    stages.step(chain.varied, chain, s, n, 0.0, no_size, 0, 1.0)
    expected = twin.acceleration(chain, u, v)
    scale = 1.0 + np.max(np.abs(expected))
    last = s.k[state.LAST * state.padded(chain.N) :]
    np.testing.assert_allclose(last[: chain.N], expected[1:], rtol=1e-12, atol=1e-13 * scale)
    assert s.k_impactor[state.LAST] == pytest.approx(expected[0], rel=1e-12, abs=1e-13 * scale)
    assert not last[chain.N :].any(), "nothing moves behind the wall"
    # A violent state has large energies of both signs, so the sum is compared with their size.
    assert model.energy(chain, u[1:], v[1:], u[0], v[0]) == pytest.approx(twin.energy(chain, u, v), rel=1e-12, abs=1e-9)
    assert model.dissipated_power(chain, v[1:]) == pytest.approx(twin.dissipated_power(chain, v), rel=1e-12)


def test_the_bistable_spring_has_a_second_stable_state():
    """Figure 1c: force zero again, with positive slope, at a large compression."""
    e = np.linspace(-0.8, -0.05, 2000)
    force = e + Bistable().excess(e)
    zeros = np.flatnonzero(np.diff(np.sign(force)) != 0)
    slopes = np.diff(force)[zeros]
    assert len(zeros) == 2
    assert (slopes > 0).tolist() == [True, False]


def test_constants_are_those_of_the_paper():
    assert pytest.approx(5.25919, rel=1e-6) == Bistable().c2
    assert pytest.approx(6.75233, rel=1e-6) == Bistable().c3
    assert pytest.approx(Bistable().energy_at(-0.46), rel=0.01) == M0 * V0**2
    chain = model.make_chain(100, 4e-4, 2.0, bistable=True)
    assert pytest.approx(2e9 / (225.7 * 1000)) == chain.contact.K
    assert chain.zeta == pytest.approx(0.04)
    assert chain.impactor_mass == pytest.approx(100 * 2 * 0.159)
