"""Which chain: the model checks itself, tells its numbers, and its uniform numbers are units."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import kernel
from kernel.ke import results_of
from kernel.lattice import FACE, PUSHING, model_of
from kernel.laws import Hertz
from kernel.method import choose
from kernel.model import chain_of, lattice_chain, linear_chain, time_of_sound


def test_the_papers_model_gives_the_papers_chain():
    for N in (2, 5, 6, 333):
        chain = lattice_chain(N, 1e-3, 0.3, kernel.Model().lattice())
        assert chain == chain_of(N, 1e-3, 0.3, kernel.Bistable())
        assert chain.contact.K == 2e9 / (225.7 * N**1.5)
        assert (chain.site, chain.t_end) == ((N + 1) // 2, 2.25 * N)


@pytest.mark.parametrize(("site", "N", "found"), [(0.7, 10, 7), (1.0, 7, 7), (0.001, 7, 1), (0.25, 100, 25)])
def test_the_site_is_the_one_that_ends_its_part_of_the_chain(site, N, found):
    assert lattice_chain(N, 0.0, 1.0, kernel.Model(site=site).lattice()).site == found


def test_every_problem_of_a_model_is_named_at_once():
    with pytest.raises(ValueError) as error:
        kernel.Model(spring=kernel.Bistable(1.0, 0.0), contact=kernel.Hertz(exponent=9), site=2, mass="a", t_end=0)
    said = str(error.value)
    assert all(word in said for word in ("spring.c3", "contact.exponent", "site: must", "mass: must", "t_end"))
    for none in (3, type("NoTuple", (), dict.fromkeys(FACE))()):  # nothing that lacks some methods
        with pytest.raises(ValueError, match=r"^spring: must be a law as kernel\.Bistable[^;]*$"):
            kernel.Model(spring=none)


class Sloped(NamedTuple):
    """A law of one's own that is linear, with any stiffness at rest."""

    slope: float

    def excess(self, e):
        return (self.slope - 1.0) * e

    def energy_at(self, e):
        return 0.5 * self.slope * e * e

    def stiffness_at(self, e):
        return self.slope

    def steepest(self, lowest, highest):
        return self.slope

    is_linear = stiffens_in_tension = stiffness_jumps = lambda self: False


@pytest.mark.parametrize("slope", [-1.0, 0.0, 0.9])
def test_a_law_that_is_not_the_linear_chains_at_rest_is_refused(slope):
    kernel.Model(spring=Sloped(1.0))
    with pytest.raises(ValueError, match=rf"spring: must have a stiffness of 1 at rest .*, got {slope}"):
        kernel.Model(spring=Sloped(slope))


class Bare(NamedTuple):
    """A law without numbers."""


@pytest.mark.parametrize(("part", "methods"), [("spring", FACE), ("contact", PUSHING)])
def test_a_law_without_numbers_which_numba_cannot_take_is_refused(part, methods):
    law = type("Cubic", (Bare,), dict.fromkeys(methods, lambda *_: 1.0))()
    with pytest.raises(ValueError, match=rf"^{part}: must be a law with at least one number, got Cubic\(\)$"):
        kernel.Model(**{part: law})


def test_a_model_tells_its_numbers_and_takes_others():
    model = kernel.Model(kernel.PiecewiseLinear((0.1, 0.3), (-0.5, 2)), kernel.Hertz(1e5))
    numbers = model.numbers()
    assert numbers["spring.slopes.1"] == 2.0
    assert numbers["contact.stiffness"] == 1e5
    assert model.with_numbers(numbers) == model
    assert model.with_numbers({"spring.slopes.0": -0.4}).spring.slopes == (-0.4, 2.0)
    with pytest.raises(ValueError, match=r"spring.slope.0.*did you mean"):
        model.with_numbers({"spring.slope.0": 1.0})
    with pytest.raises(ValueError, match=r"^1: .* number \(there are t_end, .*, contact.exponent\), got 1.0$"):
        kernel.Model().with_numbers({1: 1.0})
    with pytest.raises(ValueError, match=r"spring.c9: the model has no such number.*; site: must be a number from"):
        kernel.Model().with_numbers({"spring.c9": 1.0, "site": 3.0})


@pytest.mark.parametrize("law", [kernel.Bistable(4, 5), kernel.Toda(2), kernel.PiecewiseLinear((0.1,), (2,))])
def test_settings_make_the_same_model_again(law):
    model = kernel.Model(law, Hertz(1e6, 1.7), site=0.3)
    assert model_of(model.settings()) == model


def test_settings_that_are_wrong_are_all_named():
    with pytest.raises(ValueError) as error:
        model_of({"spring": {"law": "toda", "c": 3, "b": -1}, "contact": 3, "colour": 1, "site": 0})
    said = str(error.value)
    assert all(
        word in said for word in ("spring.c:", "spring.b: must", "contact: must", "colour: is not", "site: must")
    )
    with pytest.raises(ValueError, match="did you mean 'bistable'"):
        model_of({"spring": {"law": "bistabel"}})


def test_a_chain_without_sound_has_no_companion_and_is_refused_in_words():
    model = kernel.Model(kernel.PowerLaw(1.5, 0.0))
    for call in (kernel.ke_ratio, lambda *task, **how: kernel.measure([task], **how)):
        with pytest.raises(ValueError, match="no stiffness at rest"):
            call(20, 1e-3, 1, 1, model=model)
    with pytest.raises(ValueError, match="no stiffness at rest"):
        kernel.Scene(20, 0.0, kernel.Impact(1, 1), "linear", model=model)


@pytest.mark.parametrize("row", [np.array, pd.Series, tuple])
def test_a_list_along_the_chain_may_be_any_row_of_numbers(row):
    assert kernel.Model(mass=row([1.0, 2.0])) == kernel.Model(mass=[1, 2])


def test_mass_stiffness_and_damping_are_units_of_the_uniform_chain():
    model = kernel.Model(mass=2.0, stiffness=8.0, damping=3.0)
    chain = linear_chain(10, 1e-2, 0.3, model.lattice())
    assert chain.frequency == 2.0
    assert chain.zeta == pytest.approx(0.1 * 3.0 / 4.0)
    assert chain.impactor_mass == pytest.approx(1.5)
    assert chain.t_end == pytest.approx(45.0)


def test_quantities_are_named_or_refused():
    with pytest.raises(ValueError, match=r"observe: must be one of ke, .*did you mean 'impulse'"):
        kernel.measure([[20, 1e-3, 1, 1]], observe=("ke", "impuls"))
    with pytest.raises(ValueError, match="distinct"):
        kernel.measure([[20, 1e-3, 1, 1]], observe=())


def test_the_kinetic_energy_has_two_names_in_scenes_and_measurements_alike():
    """Each took one of the names only, where a spec takes both."""
    found, same = (kernel.measure([[20, 1e-3, 1, 1]], observe=name) for name in ("ke", "peak_ke"))
    assert found.dtype == same.dtype
    assert found["ke"] == same["ke"]
    seen = kernel.simulate(kernel.Scene(20, 1e-3, kernel.Impact(1, 1), observe=("ke", "peak_ke")))
    assert seen["ke"] == seen["peak_ke"]
    with pytest.raises(ValueError, match="distinct"):
        kernel.measure([[20, 1e-3, 1, 1]], observe=("ke", "peak_ke"))


@pytest.mark.parametrize("row", [np.array, pd.Series])
def test_the_strains_and_slopes_of_straight_pieces_may_be_rows_of_arrays(row):
    law = kernel.PiecewiseLinear(row([0.1, 0.3]), row([-0.5, 2.0]))
    assert kernel.Model(law) == kernel.Model(kernel.PiecewiseLinear((0.1, 0.3), (-0.5, 2.0)))
    with pytest.raises(ValueError, match=r"^spring\.strains: must ascend, got \[0\.3, 0\.1\]$"):
        kernel.Model(kernel.PiecewiseLinear(row([0.3, 0.1]), row([-0.5, 2.0])))


def test_a_release_is_checked():
    with pytest.raises(ValueError) as error:
        kernel.Release(["a"], [np.nan])
    assert "u: must" in str(error.value)
    assert "v: must" in str(error.value)
    with pytest.raises(ValueError, match="as many, got 2 and 3"):
        kernel.Release([0, 0], [1, 2, 3])
    with pytest.raises(ValueError, match="must not all be 0"):
        kernel.Release([0, 0], [0, 0])
    with pytest.raises(ValueError, match="as many displacements as there are sites, got 2"):
        kernel.Scene(3, 0.0, kernel.Release([0, 0], [0, 1]))
    with pytest.raises(ValueError, match=r"^v: must be 0 for the first site, which is held, got 0\.1$"):
        kernel.Release([0, 0], [0.1, 0], hold=True)
    assert kernel.Release([0, 0], [0, 0.1], hold=True).hold


def test_a_released_state_without_energy_or_with_more_than_a_float_holds_is_refused():
    strained, alike = kernel.Release([10.0, 0.0], [0.0, 0.0]), kernel.Release([0.1, 0.1], [0.0, 0.0])
    with pytest.raises(ValueError, match="event: its state must have a finite energy above 0, got inf"):
        kernel.Scene(2, 0.0, strained, observe="energy", model=kernel.Model(spring=kernel.Toda(100.0)))
    with pytest.raises(ValueError, match="event: its state must have a finite energy above 0, got 0"):
        kernel.Scene(2, 0.0, alike, observe="energy", model=kernel.Model(wall="free"))


@settings(max_examples=10)
@example(26, 1.0, 0.37890625, "uniform")
@given(st.integers(5, 60), st.floats(0.1, 10), st.floats(0.1, 10), st.sampled_from(["uniform", "stiff", "listed"]))
def test_a_run_that_ends_when_sound_has_come_is_that_of_a_shorter_model_and_its_linear_chain_goes_on(N, M, V, kind):
    mass = {"uniform": 1.0, "stiff": 1.0, "listed": [1.0 + 0.5 * (i % 2) for i in range(N)]}[kind]
    model = kernel.Model(stiffness=4.0 if kind == "stiff" else 1.0, mass=mass)
    columns = {"N": np.array([N]), "zeta_T": np.array([1e-3]), "M_over_M0": np.array([M]), "V_over_V0": np.array([V])}
    end = 1.5 * time_of_sound(model.lattice(N), N)
    integrator = choose("auto", 1e-2)
    (early,), (whole,) = (results_of(columns, integrator, False, model=model, until=until) for until in (1.5, math.inf))
    (short,) = results_of(columns, integrator, False, model=replace(model, t_end=end))
    assert early["ke_bistable"] == short["ke_bistable"]
    if early["t_peak_bistable"] < 0.95 * end:
        assert early["ke_bistable"] <= whole["ke_bistable"]
    else:  # a peak in the last step, which ends with the run, is told by a shorter one than in the whole run
        assert early["ke_bistable"] <= whole["ke_bistable"] * (1.0 + 1e-4)
    assert early["ke_linear"] == whole["ke_linear"] >= short["ke_linear"]


@pytest.mark.parametrize("numbers", [3, None, ["t_end"], "t_end"])
def test_numbers_of_a_model_come_by_their_names(numbers):
    with pytest.raises(ValueError, match=r"^numbers: must be a mapping of names to numbers, got "):
        kernel.Model().with_numbers(numbers)


C2, C3 = kernel.Bistable()


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (kernel.Model(), kernel.Model(spring=kernel.Polynomial(C2, C3))),
        (kernel.Model(mass=kernel.Graded(0.5, 1)), kernel.Model(mass=kernel.Disordered(0.5, 1))),
        (kernel.Model(damping=kernel.Graded(0.5, 1)), kernel.Model(damping=[0.5, 1])),
        (kernel.Drive(kernel.HalfSine(0.1, 0.5)), kernel.Drive(kernel.Harmonic(0.1, 0.5))),
    ],
)
def test_what_holds_the_same_numbers_in_laws_or_forms_of_different_kinds_is_not_the_same(one, other):
    same = replace(one)
    assert one == same != other
    assert len({one, same, other}) == 2
    assert one != 3


def test_scenes_of_models_of_different_kinds_differ():
    one, same, other = (
        kernel.Scene(5, 0.0, kernel.Impact(1, 1), model=kernel.Model(spring))
        for spring in (kernel.Bistable(), kernel.Bistable(), kernel.Polynomial(C2, C3))
    )
    assert one == same != other
