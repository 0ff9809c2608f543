"""Predicted work follows the work that is done, and a running sweep's estimate follows what it has seen."""

import numpy as np
import pytest

from kernel.ke import results_of
from kernel.lattice import Model
from kernel.laws import SPRINGS, Hertz, Toda
from kernel.method import AUTO, COARSE_TO, EXPLICIT, choose, looser
from kernel.splitting import explicit, implicit
from sweep.plan import chains, cost, laws
from sweep.plan.cost import PARAMETERS, first_run, predict_work
from sweep.store.runs import new_run, seconds_to_go

from . import calibrate, measured

COUNT = 300


def drawn(seed: int) -> dict[str, np.ndarray]:
    """Random tasks of the paper's domain, up to 200 sites."""
    rng = np.random.default_rng(seed)
    N = (10 ** rng.uniform(0.7, 2.3, COUNT)).astype(int)
    return dict(
        zip(PARAMETERS, (N, *(10 ** rng.uniform(a, b, COUNT) for a, b in ((-5, 0), (-1, 1), (-1, 1)))), strict=True)
    )


@pytest.mark.parametrize(("seed", "durations"), [(1, [2.25]), (4, [0.5, 2.25, 6.0])])
def test_the_order_by_predicted_work_is_that_of_the_work_done(seed, durations):
    """Of all tasks, and better of those that one method serves: another's site evaluations take another time."""
    columns, integrator = drawn(seed), choose()
    columns["t_end"] = np.resize(durations, COUNT)
    rows, told = results_of(columns, integrator, certify=False), predict_work(columns, integrator, False, Model())
    explicit_ones, implicit_ones = (rows["method"] == method for method in ("explicit", "implicit"))
    for served, at_least in ((np.ones(COUNT, bool), 0.85), (explicit_ones, 0.93), (implicit_ones, 0.83)):
        ranks = [np.argsort(np.argsort(x[served])) for x in (rows["site_evaluations"], told)]
        assert np.corrcoef(*ranks)[0, 1] > at_least


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
    for which, begun in cost.begun_with(columns, integrator):
        run, companion = (first_run(columns, x)[which] for x in (begun, looser(begun)))
        both = begun.accuracy > integrator.accuracy  # are extrapolated, certified or not
        np.testing.assert_allclose(plain[which], run + companion if both else run, rtol=1e-12)
        assert (certified[which] > (1.0 if both else 1.3) * plain[which]).all()


@pytest.mark.parametrize("integrator", [choose(), choose("auto", 1e-7), choose("rk45", rtol=1e-3, atol=1e-6)], ids=str)
def test_a_law_of_refinement_has_a_coefficient_for_every_feature_and_none_more(integrator):
    columns = drawn(2)
    found = len(list(cost.features(columns, integrator)))
    used = (laws.EXPLICIT_MORE, laws.IMPLICIT_MORE) if integrator.kind == AUTO else (laws.RK45_MORE,)
    assert {len(law) for law in used} == {found}
    assert all(law[-1] != 0.0 for law in used)


def test_the_coefficients_written_by_the_fit_are_those_that_are_read():
    fitted = {name: getattr(laws, f"{name}_LAW") for name in calibrate.FITTED}
    mores = {name: getattr(laws, f"{name}_MORE") for name in calibrate.MORES}
    text = calibrate.written(fitted, mores)
    assert text == calibrate.LAWS.read_text()
    changed = calibrate.written(fitted | {"AUTO_RK45": fitted["AUTO_RK45"]._replace(c=1.5)}, mores)
    differ = [line for line in changed.splitlines() if line not in text.splitlines()]
    assert len(differ) == 1
    assert differ[0].startswith("AUTO_RK45_LAW = Law(1.5, ")


def test_a_chain_with_other_units_and_duration_is_predicted_by_what_it_is_in_its_own():
    """Twice the mass and eight times the stiffness: sound is twice as fast.

    Each crossing of sound costs the same, but for the first, with the impact, and later ones that are stepped coarsely.
    """
    columns, integrator = drawn(3), choose()
    same = Model(mass=2.0, stiffness=8.0, damping=4.0, t_end=2.25 / 2.0)
    halved = columns | {name: columns[name] / 2.0 for name in ("M_over_M0", "V_over_V0")}
    for certify in (False, True):
        told = predict_work(columns, integrator, certify, same)
        np.testing.assert_allclose(told, predict_work(halved, integrator, certify))
        short, paper, coarse, long, longer = (
            predict_work(columns, integrator, certify, Model(t_end=x)) for x in (1.0, 2.25, COARSE_TO, 8.0, 15.0)
        )
        np.testing.assert_allclose(longer - long, long - short, rtol=1e-9)
        light = cost.methods(columns, integrator) == EXPLICIT
        for more, times in ((paper - short, 1.25), (coarse - short, COARSE_TO - 1.0)):
            fine = (long - short) * times / 7.0
            assert np.all(more[light] < 0.999 * fine[light])
            assert np.all((more > 0.0) & (more < 1.001 * fine))
    axis = predict_work(columns | {"t_end": np.full(COUNT, 9.0)}, integrator, True, Model())
    np.testing.assert_array_equal(axis, predict_work(columns, integrator, True, Model(t_end=9.0)))


@pytest.mark.parametrize("t_end", [0.5, 1.0, 6.0])
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_the_same_tasks_take_as_much_more_or_less_in_another_time_as_predicted(method, t_end):
    """The impact's steps are as many however long the run is, sites wait for the wave, and later steps are coarse."""
    columns, integrator = drawn(4), choose()
    worked, predicted = [], []
    for duration in (t_end, 2.25):
        there = columns | {"t_end": np.full(COUNT, duration)}
        rows = results_of(there, integrator, certify=False)
        served = rows["method"] == method
        worked.append(rows["site_evaluations"][served].sum())
        predicted.append(predict_work(there, integrator, False, Model())[served].sum())
    assert predicted[0] / predicted[1] == pytest.approx(worked[0] / worked[1], rel=0.3)


@pytest.mark.parametrize("other", [{}, {"t_end": 1.0}, {"mass": 4.0}, {"stiffness": 4.0}, {"site": 0.9, "t_end": 3.0}])
def test_screening_takes_the_share_of_a_task_that_is_predicted(other):
    columns, integrator, model = drawn(5), choose("auto", 0.1), Model(**other)
    screened, whole = (results_of(columns, integrator, False, model=model, until=x) for x in (1.5, np.inf))
    share = (screened["site_evaluations"] / whole["site_evaluations"]).mean()
    assert share == pytest.approx(chains.share_until(1.5, model, sharing=1.0), rel=0.06)


@pytest.mark.parametrize(("dampers", "zeta_T"), [("weak", 1e-4), ("strong", 1.0)])
def test_quantities_are_predicted_to_cost_what_the_benchmarks_say(dampers, zeta_T):
    figures = {row["what"]: row["figure"] for row in measured.kept("measure")["rows"]}
    _, every = figures[f"those of 4096 tasks with {dampers} dampers: one quantity, all over none"].split(", ")
    task = {name: np.array([value]) for name, value in zip(PARAMETERS, (50, zeta_T, 1.0, 1.0), strict=True)}
    without, seen = (predict_work(task, choose(), True, quantities=count) for count in (0, 2))
    assert seen / without == pytest.approx(float(every), rel=0.05)


def test_sites_wait_for_the_wave_as_many_as_the_kernel_lets_wait():
    assert laws.FIRST_SITES == {"EXPLICIT": explicit.FIRST_SITES, "IMPLICIT": implicit.FIRST_SITES}


def test_what_a_plan_of_another_chain_leaves_out_is_said():
    said = chains.assumptions(Model(spring=Toda(2.0), t_end=5.0, wall="free"), 2)
    assert [line.partition(":")[0] for line in said] == [
        'law "toda"',
        "t_end",
        "not uniform, or a free end",
        "quantities",
        "compiling",
    ]
    harder, axes = Model(contact=Hertz(1e10)), ["contact.stiffness", "spring.c2"]
    for said, words in (
        (chains.assumptions(harder, 0), ["contact", "compiling"]),
        (chains.assumptions(Model(), 0, axes[:1]), ["contact", "compiling"]),
        (chains.assumptions(Model(), 0, axes), ["the law's c2 and c3", "contact", "compiling"]),
    ):
        assert [line.partition(":")[0] for line in said] == words
    assert chains.assumptions(None, 0) == []
    assert chains.assumptions(Model(), 0) == []
    assert set(chains.FACTORS) == set(SPRINGS), "every law has its factor"


def test_the_estimate_corrects_itself_by_what_was_finished():
    run = new_run(100, "gather", "0")
    run["work_left"], run["work_running"], run["computing"] = 40.0, 10.0, 2
    assert seconds_to_go(run[0]) is None
    run["work_finished"] = 10.0  # in no time, by which nothing can be told
    assert seconds_to_go(run[0]) is None
    run["busy"] = 30.0
    assert seconds_to_go(run[0]) == pytest.approx(3.0 * (40.0 + 5.0) / 2)
