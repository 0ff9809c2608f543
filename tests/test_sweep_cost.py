"""Predicted work follows the work that is done, and a running sweep's estimate follows what it has seen."""

import numpy as np
import pytest

from kernel.ke import results_of
from kernel.method import AUTO, choose
from sweep.plan import cost, laws
from sweep.plan.cost import PARAMETERS, first_run, predict_work
from sweep.store.runs import new_run, seconds_to_go

from . import calibrate

COUNT = 300


def drawn(seed: int) -> dict[str, np.ndarray]:
    """Random tasks of the paper's domain, up to 200 sites."""
    rng = np.random.default_rng(seed)
    N = (10 ** rng.uniform(0.7, 2.3, COUNT)).astype(int)
    return dict(
        zip(PARAMETERS, (N, *(10 ** rng.uniform(a, b, COUNT) for a, b in ((-5, 0), (-1, 1), (-1, 1)))), strict=True)
    )


def test_the_order_by_predicted_work_is_that_of_the_work_done():
    columns, integrator = drawn(1), choose()
    done = results_of(columns, integrator, certify=False)["site_evaluations"]
    ranks = [np.argsort(np.argsort(x)) for x in (done, predict_work(columns, integrator, certify=False))]
    assert np.corrcoef(*ranks)[0, 1] > 0.85


@pytest.mark.parametrize("target", [1e-3, 1e-4])
def test_certification_costs_as_many_times_more_as_predicted_to_thirty_percent(target):
    columns, integrator = drawn(2), choose("auto", target)
    done = [results_of(columns, integrator, certify)["site_evaluations"] for certify in (True, False)]
    predicted = [predict_work(columns, integrator, certify) for certify in (True, False)]
    for told in (lambda whole, plain: whole.sum() / plain.sum(), lambda whole, plain: (whole / plain).mean()):
        assert told(*predicted) == pytest.approx(told(*done), rel=0.3)


@pytest.mark.parametrize("integrator", [choose(), choose("auto", 1e-7), choose("rk45", rtol=1e-3, atol=1e-6)], ids=str)
def test_certification_is_predicted_to_cost_at_least_its_companion(integrator):
    columns = drawn(2)
    plain, certified = (predict_work(columns, integrator, certify) for certify in (False, True))
    assert (certified > 1.3 * plain).all()
    np.testing.assert_array_equal(plain, first_run(columns, integrator))


@pytest.mark.parametrize("integrator", [choose(), choose("auto", 1e-7), choose("rk45", rtol=1e-3, atol=1e-6)], ids=str)
def test_a_law_of_refinement_has_a_coefficient_for_every_feature_and_none_more(integrator):
    columns = drawn(2)
    found = len(list(cost.features(columns, integrator)))
    used = (laws.EXPLICIT_MORE, laws.IMPLICIT_MORE) if integrator.kind == AUTO else (laws.RK45_MORE,)
    assert {len(law) for law in used} == {found}
    assert all(law[-1] != 0.0 for law in used)


def test_the_coefficients_written_by_the_fit_are_those_that_are_read():
    fitted = {name: getattr(laws, f"{name}_LAW") for name in laws.FITTED}
    mores = {name: getattr(laws, f"{name}_MORE") for name in calibrate.MORES}
    text = calibrate.written(fitted, mores)
    assert text == calibrate.LAWS.read_text()
    changed = calibrate.written(fitted | {"AUTO_RK45": fitted["AUTO_RK45"]._replace(c=1.5)}, mores)
    differ = [line for line in changed.splitlines() if line not in text.splitlines()]
    assert len(differ) == 1
    assert differ[0].startswith("AUTO_RK45_LAW = Law(1.5, ")


def test_the_estimate_corrects_itself_by_what_was_finished():
    run = new_run(100, 60.0, 2, 2, "gather", "0")
    run["work_left"], run["work_running"] = 40.0, 10.0
    assert seconds_to_go(run[0]) is None
    run["work_finished"], run["busy"] = 10.0, 30.0
    assert seconds_to_go(run[0]) == pytest.approx(3.0 * (40.0 + 5.0) / 2)
