"""Every law through every integrator, and every quantity, against scipy's DOP853."""

import numpy as np
import pytest

import kernel
from kernel import rk45
from kernel.integrate import DOUBLE, explicit_rule, implicit_rule, run_explicit, run_implicit
from kernel.laws import Bistable, PiecewiseLinear, Polynomial, PowerLaw, Toda
from kernel.laws.any_power import AnyPower
from kernel.model import PAPER_CONTACT, Lattice, lattice_chain
from kernel.quantities import QUANTITIES
from kernel.status import DONE
from kernel.task import M0, V0
from kernel.watch import largest_of, new_watch

from . import exact

pytestmark = pytest.mark.slow

N, V, ACCURACY = 9, 2.0 * V0, 1e-4
BOUNDS = {"rk45": 1e-6, "explicit": 3e-4, "implicit": 1e-3}  # relative error of the site's largest speed


def chain_with(spring, zeta_T, contact=None, site=0.5, mass=1.0, stiffness=1.0, damping=1.0):
    lattice = Lattice(spring, contact or PAPER_CONTACT, 1.5, site, mass, stiffness, damping)
    return lattice_chain(N, zeta_T, 2.0 * M0, lattice)


def all_runs(chain, quantities):
    """By each integrator: run, and its numbers of the quantities."""
    for method in ("explicit", "implicit", "rk45"):
        if (method == "implicit") != (chain.zeta > 0.4) and method != "rk45":
            continue
        watch = new_watch(quantities)
        if method == "explicit":
            rule = explicit_rule(chain, ACCURACY)
            run = run_explicit(chain, V, rule, rule, 10**7, 0.0, watch, DOUBLE)
        elif method == "implicit":
            damped = implicit_rule(chain, V, ACCURACY)
            run = run_implicit(chain, V, damped, damped, 10**7, watch)
        else:
            run = rk45.integrate(chain, V, 1e-8, 1e-11, 10**7, chain.t_end, watch)
        assert run.status == DONE, method
        yield method, run, largest_of(watch, chain, V)


LAWS = [
    Polynomial(-1.0, 3.0),
    PiecewiseLinear((0.1, 0.3), (-0.5, 2.0)),
    PowerLaw(1.5, 0.05),
    Toda(3.0),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_every_law_runs_by_every_integrator_as_by_scipy(law):
    for zeta_T in (2e-3, 0.08):
        chain = chain_with(law, zeta_T)
        true = exact.largest(exact.run(chain, V, 1e-9), lambda y: y[N + 1 + chain.site])  # noqa: B023
        for method, run, _ in all_runs(chain, ()):
            assert run.speed == pytest.approx(true, rel=BOUNDS[method]), (method, zeta_T)


def test_every_quantity_is_what_scipy_finds_by_every_integrator():
    asked = tuple(QUANTITIES.values())
    for zeta_T, numbers in (
        (2e-3, {}),
        (0.08, {}),
        (2e-3, {"site": 0.25, "mass": 2.0, "stiffness": 3.0, "damping": 0.7}),
    ):
        chain = chain_with(Bistable(), zeta_T, **numbers)
        true = exact.numbers(chain, V)
        for method, run, found in all_runs(chain, asked):
            # Relatively; and of energies so small a share of TE is known.
            loose, of_TE = {"rk45": (1e-4, 2e-5), "explicit": (3e-3, 2e-5), "implicit": (3e-3, 1e-3)}[method]
            assert run.speed == pytest.approx(true["speed"], rel=BOUNDS[method])
            for name, number in zip(QUANTITIES, found, strict=True):
                bound = max(loose * abs(true[name]), of_TE)
                assert abs(number - true[name]) <= bound, (name, method, zeta_T, number, true[name])


def test_a_contact_of_another_power_runs_as_by_scipy():
    chain = chain_with(Bistable(), 2e-3, AnyPower(8e6, 1.8))
    true = exact.largest(exact.run(chain, V, 1e-9), lambda y: y[N + 1 + chain.site])
    for method, run, _ in all_runs(chain, ()):
        assert run.speed == pytest.approx(true, rel=BOUNDS[method]), method


@pytest.mark.parametrize(
    ("spring", "task"),
    [
        (kernel.Bistable(6.955284, 6.752326), (80, 2e-3, 0.05, 1.0)),
        (kernel.Bistable(6.955284, 6.752326), (80, 4e-2, 0.05, 1.0)),
        (kernel.Polynomial(6.5, 6.0), (80, 2e-3, 0.05, 1.0)),
        (kernel.Polynomial(-6.5, 6.0), (80, 2e-3, 0.05, 1.0)),
    ],
)
def test_chains_whose_second_well_lies_below_rest_run_by_the_fast_methods_as_by_rk45(spring, task):
    model = kernel.Model(spring=spring)
    fast = kernel.ke_ratio(*task, accuracy=1e-4, certify=False, model=model)
    tight = kernel.ke_ratio(*task, accuracy=1e-5, method="rk45", certify=False, model=model)
    assert (fast.method != "rk45", fast.status, tight.status) == (True, "done", "done")
    assert fast.ke_bistable == pytest.approx(tight.ke_bistable, rel=1e-4)


@pytest.mark.parametrize(
    ("c2", "c3", "task"), [(-2.38528, 0.532739, (5, 0.0, 4.2, 3.07)), (-0.901146, 0.0881213, (6, 0.0, 47.0, 1.93))]
)
def test_a_well_in_tension_further_from_rest_than_any_link_is_compressed_is_no_blow_up(c2, c3, task):
    model = kernel.Model(spring=kernel.Polynomial(c2, c3))
    fast = kernel.ke_ratio(*task, certify=False, model=model)
    tight = kernel.ke_ratio(*task, method="rk45", accuracy=1e-6, certify=False, model=model)
    assert (fast.method, fast.status, tight.status) == ("explicit", "done", "done")
    assert fast.ke_ratio == pytest.approx(tight.ke_ratio, rel=1e-3)


def test_a_faint_impact_may_set_more_energy_free_than_it_brings():
    model = kernel.Model(spring=kernel.Bistable(6.955284, 6.752326))
    for method in ("auto", "rk45"):
        assert kernel.ke_ratio(80, 4e-5, 0.05, 1.0, method=method, certify=False, model=model).ke_bistable > 5.0


def test_where_the_stiffness_jumps_the_splitting_reaches_its_target_on_random_tasks():
    """Steps are of second order there: with those of smooth laws 62 % of lightly damped tasks are within 1e-3."""
    rng, count = np.random.default_rng(20261126), 200
    tasks = {
        "N": rng.integers(10, 60, count),
        "zeta_T": 10 ** rng.uniform(-5, -3, count),
        "M_over_M0": 10 ** rng.uniform(-1, 1, count),
        "V_over_V0": 10 ** rng.uniform(-1, 1, count),
    }
    model = kernel.Model(spring=PiecewiseLinear((0.1, 0.3), (-0.5, 2.0)))
    tight = kernel.ke_ratios(tasks, 1e-6, method="rk45", certify=False, model=model)
    fast = kernel.ke_ratios(tasks, 1e-3, certify=False, model=model)
    assert set(fast["method"].tolist()) == {"explicit"}
    assert np.mean(np.abs(fast["ke_ratio"] / tight["ke_ratio"] - 1.0) < 1e-3) > 0.8
