"""Accuracy means what it says, the error covers, chaos is flagged: on a sample of the stored references."""

import numpy as np
import pytest

import kernel
from kernel.along import Disordered, Graded
from kernel.certify import still_counts
from kernel.condition import CHAOTIC, DISTURBANCE, MEASURED_AGAIN_TO, condition_of, seen_early
from kernel.estimate import error_felt, error_of, has_a_jump, may_agree_by_chance
from kernel.ke import PARAMETERS, results_of
from kernel.lattice import Model
from kernel.laws import Polynomial
from kernel.method import FAR, NEAR, choose, looser
from kernel.model import disturb
from kernel.pairs import Rung, ScaledTask, pair_of

from . import promises
from .test_kernel_arrival import EARLY, pair_at


@pytest.mark.parametrize("target", [1e-2, 1e-3, 1e-4])
def test_the_promises_hold_on_the_shorter_references(target):
    """The whole set is a program: python -m tests.promises."""
    assert promises.kept(promises.references(largest=120), target).broken == []


def chaotic_task() -> dict[str, float]:
    data = promises.references(largest=120)
    worst = data[np.argmax(data["condition"])]
    assert worst["condition"] > 1e4
    return {name: worst[name].item() for name in PARAMETERS}


def test_a_chaotic_task_has_an_interval_that_holds_its_neighbours():
    task = chaotic_task() | {"N": int(chaotic_task()["N"])}
    r = kernel.ke_ratio(**task)
    assert r.chaotic
    assert r.spread_low <= r.ke_ratio <= r.spread_high
    assert r.error * r.ke_ratio >= max(r.spread_high - r.ke_ratio, r.ke_ratio - r.spread_low) * (1 - 1e-12)
    tight = kernel.ke_ratio(**task, method="rk45", rtol=1e-11, atol=1e-14, certify=False).ke_ratio
    width = r.spread_high - r.spread_low
    assert r.spread_low - 2 * width < tight < r.spread_high + 2 * width


def test_a_task_that_is_not_chaotic_has_no_interval():
    r = kernel.ke_ratio(20, 1e-2, 1.0, 1.0)
    assert not r.chaotic
    assert np.isnan([r.spread_low, r.spread_high]).all()


def test_a_calm_task_costs_less_than_two_runs():
    calm = {"N": 60, "zeta_T": 1e-2, "M_over_M0": 1.0, "V_over_V0": 1.0}
    plain, certified = (kernel.ke_ratio(**calm, certify=certify) for certify in (False, True))
    assert certified.site_evaluations < 2 * plain.site_evaluations


def test_what_looser_steps_show_to_be_chaotic_is_run_no_tighter():
    columns = {name: np.array([value]) for name, value in chaotic_task().items()}
    x = choose(accuracy=1e-3)
    (row,), (loose,), (plain,) = (
        results_of(columns, y, certify) for y, certify in ((x, True), (looser(x), False), (x, False))
    )
    assert row["chaotic"] and row["condition"] > MEASURED_AGAIN_TO
    assert row["ke_ratio"] == loose["ke_ratio"] != plain["ke_ratio"]
    assert row["site_evaluations"] < 2 * plain["site_evaluations"]


@pytest.mark.parametrize("target", [1e-2, 1e-3])
def test_a_chaotic_task_costs_less_than_six_runs(target):
    data = promises.references(largest=120)
    chaotic = {name: data[name][data["shown"] > CHAOTIC] for name in PARAMETERS}
    plain, certified = (results_of(chaotic, choose(accuracy=target), certify) for certify in (False, True))
    assert certified["chaotic"].mean() > 0.9
    assert certified["site_evaluations"].sum() < 6 * plain["site_evaluations"].sum()


def test_a_refinement_that_runs_out_of_steps_leaves_what_the_runs_before_it_told():
    """Its first two runs differ by three targets, which it reaches with one more."""
    task = (26, 0.0004294416618731822, 0.1986447845480973, 2.4947324759215777)
    full, stopped = kernel.ke_ratio(*task), kernel.ke_ratio(*task, max_steps=327)
    assert full.error < 1e-3 < stopped.error < 5e-3
    assert stopped.status == "done"
    assert 0.0 < abs(stopped.ke_ratio / full.ke_ratio - 1) <= stopped.error
    assert stopped.checked


def test_at_tolerances_of_ones_own_the_error_is_at_least_what_a_finer_run_shows():
    task = (20, 1e-4, 2, 0.5)
    own, fine = kernel.ke_ratio(*task, method="rk45", rtol=1e-5, atol=1e-8), kernel.ke_ratio(*task, accuracy=1e-5)
    assert 0.01 < abs(own.ke_ratio / fine.ke_ratio - 1) <= 1.05 * own.error


def neighbours(row, rtol=1e-10):
    """Largest relative change of a task's tight ke_ratio, over that of its start, for disturbances of two sizes."""
    columns, tight = {name: row[name] for name in PARAMETERS}, choose("rk45", rtol=rtol, atol=1e-3 * rtol)
    here, *there = (results_of(columns, tight, False, x)["ke_ratio"][0] for x in (0.0, DISTURBANCE, DISTURBANCE / 4))
    return max(abs(x / here - 1) / d for x, d in zip(there, (DISTURBANCE, DISTURBANCE / 4), strict=True))


def test_the_condition_number_is_what_neighbours_recomputed_tightly_show():
    """Told by a companion to a factor, measured where it is large; chaotic is a threshold of it and nothing else."""
    data = promises.references(largest=60)
    rows = kernel.ke_ratios({name: data[name] for name in PARAMETERS}, 1e-4)
    rows = rows[rows["status"] == "done"][:60]
    true = np.array([neighbours(rows[i : i + 1]) for i in range(len(rows))])
    assert (rows["chaotic"] == (rows["condition"] > CHAOTIC)).all()
    sensitive = (true > 50) & (true < 1e5)
    assert sensitive.sum() > 3
    assert 0.4 < np.median(rows["condition"][sensitive] / true[sensitive]) < 2.5
    assert np.mean(rows["condition"] > 0.2 * true) > 0.9


@pytest.mark.parametrize("target", [1e-4, 1e-5])
def test_a_task_whose_crests_change_places_at_a_ten_millionth_is_chaotic(target):
    """A millionth moves it by 7e-4, as the crests have changed places by then; condition number 4450."""
    assert kernel.ke_ratio(75, 0.0, 0.4915300196378595, 0.32532417815604786, target).chaotic


@pytest.mark.parametrize("target", [1e-5, 1e-6])
def test_a_task_that_one_disturbance_leaves_and_another_one_moves_is_chaotic(target):
    """Two draws of first velocities move it by 2600 and by 12000 times their size, another mass or speed by 400."""
    assert kernel.ke_ratio(48, 1.1965293501122762e-05, 8.478585162332056, 2.2669557955036357, target).chaotic


def test_a_disturbance_of_the_other_sign_has_first_velocities_of_its_own():
    one, other = np.zeros(1000), np.zeros(1000)
    disturb(one, 1000, 1.0)
    disturb(other, 1000, -1.0)
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.15
    for v in (one, other):
        assert abs(v.mean()) < 0.1
        assert 0.9 < np.abs(v).max() <= 1.0


@pytest.mark.parametrize("target", [1e-3, 1e-4])
def test_a_task_that_damping_alone_moves_is_chaotic(target):
    """A billionth more of zeta_T moves it by 4e-3, a millionth of mass and speed by 3e-4."""
    model = Model(spring=Polynomial(-1.0, 3.0))
    assert kernel.ke_ratio(79, 4.273900177960884e-06, 4.604959799173026, 4.378338372038722, target, model=model).chaotic


@pytest.mark.parametrize(
    ("last", "task"),
    [(10.0, (16, 0.0, 3.81, 2.52, 37)), (1.0, (23, 0.0, 23.64, 1.36, 59))],
    ids=["graded", "disordered"],
)
def test_steps_that_do_more_than_a_disturbance_are_not_chaos_of_a_chain_that_is_not_uniform(last, task):
    """Neighbours at 1e-6, recomputed tightly, differ by 1e-6 to 2e-6; at the probe's rtol of 1e-6 by half."""
    *task, seed = task
    site = 0.5 if last > 1.0 else 0.25
    model = Model(mass=Disordered(0.3, seed), stiffness=Graded(1.0, last), site=site)
    tight = kernel.ke_ratio(*task, method="rk45", rtol=1e-12, certify=False, model=model).ke_ratio
    for target in (1e-2, 1e-3):
        r = kernel.ke_ratio(*task, target, model=model)
        assert not r.chaotic
        assert r.condition < 10.0
        assert abs(r.ke_ratio / tight - 1.0) < r.error < target


def test_tolerances_that_are_too_loose_are_not_chaos():
    rng = np.random.default_rng(3)
    tasks = 10 ** rng.uniform((0.7, -5, -1, -1), (1.7, -2, 1, 1), (60, 4))
    tasks[:, 0] = np.round(tasks[:, 0])
    loose, fine = kernel.ke_ratios(tasks, method="rk45", rtol=1e-2, atol=1e-5), kernel.ke_ratios(tasks, 1e-3)
    assert np.count_nonzero(loose["chaotic"] & ~fine["chaotic"]) <= 0.05 * len(tasks)
    assert (np.abs(loose["ke_ratio"] / fine["ke_ratio"] - 1) > 0.1).any()


def test_a_stiff_task_is_refined_without_an_explicit_integrator():
    """Its step would be bounded by the dampers: four times the time at some 70 sites, sixty at 400."""
    task = {"N": 68, "zeta_T": 0.9117262383408001, "M_over_M0": 0.2620025057515427, "V_over_V0": 5.72561193320442}
    plain, certified = (kernel.ke_ratio(**task, accuracy=5e-4, certify=certify) for certify in (False, True))
    assert certified.ke_ratio != plain.ke_ratio
    assert certified.method == "implicit"
    tight = kernel.ke_ratio(**task, accuracy=1e-8, method="rk45", certify=False)
    assert abs(certified.ke_ratio / tight.ke_ratio - 1) < certified.error < 5e-4


def test_a_target_beyond_the_step_budget_is_a_status_with_the_best_value():
    """A few percent of the references need a refinement at 1e-3; with no steps left for it they keep what they have."""
    data = promises.references(largest=200)
    tasks = {name: data[name] for name in PARAMETERS}
    free = kernel.ke_ratios(tasks, 1e-4)
    most = int(np.quantile(free["steps"], 0.7))
    bounded = kernel.ke_ratios(tasks, 1e-4, max_steps=most)
    poor = bounded["status"] == "not_converged"
    assert poor.sum() > (free["status"] == "not_converged").sum()
    assert np.isfinite(bounded["ke_ratio"][poor]).all()
    assert (bounded["error"][poor] > 1e-4).all()
    spent = bounded["status"] == "step_budget"
    assert np.isnan(bounded["ke_ratio"][spent]).all()


def test_a_batch_gives_the_bits_of_its_tasks_alone_in_any_order():
    data = promises.references(largest=80)[:40]
    tasks = {name: data[name] for name in PARAMETERS}
    together = kernel.ke_ratios(tasks)
    backwards = kernel.ke_ratios({name: values[::-1] for name, values in tasks.items()})[::-1]
    assert together.tobytes() == backwards.tobytes()
    alone = np.concatenate(
        [kernel.ke_ratios({name: values[i : i + 1] for name, values in tasks.items()}) for i in range(40)]
    )
    assert together.tobytes() == alone.tobytes()


def test_a_bad_row_of_a_batch_has_a_status_and_the_others_are_computed():
    rows = kernel.ke_ratios([[20, 1e-3, 1, 1], [20, -1, 1, 1], [2.5, 0, 1, 1], [20, np.nan, 1, 1], [20, 1e-3, 1, 1]])
    assert rows["status"].tolist() == ["done", "bad_input", "bad_input", "bad_input", "done"]
    assert rows["ke_ratio"][0] == rows["ke_ratio"][4] == kernel.ke_ratio(20, 1e-3, 1.0, 1.0).ke_ratio
    assert np.isnan(rows["ke_ratio"][1:4]).all()
    with pytest.raises(ValueError, match=r"tasks: must be a mapping, .* got shape \(1, 3\)"):
        kernel.ke_ratios([[20, 1e-3, 1]])


@pytest.mark.parametrize(
    ("accuracy", "task"),
    [
        (1e-3, (69, 7.842001462089136e-06, 2.808344695841944, 0.3521914749718517)),
        (1e-4, (160, 0.0, 0.2490814861760452, 7.027363915974229)),
        (1e-4, (221, 3.335852692817672e-05, 0.672016518693143, 0.554353101946774)),
    ],
)
def test_a_run_is_not_believed_to_be_better_than_its_condition_number_allows(accuracy, task):
    """Run and companion of these sensitive tasks agree by chance: what they differ by is less than the error."""
    true = kernel.ke_ratio(*task, method="rk45", rtol=1e-11, atol=1e-14, certify=False).ke_ratio
    scaled, x, first = pair_at(task, 0.3 * accuracy)
    loose = looser(x)
    rung = Rung(first, x, pair_of(scaled, loose, np.zeros(3), False), loose)
    early = seen_early(scaled, loose, np.zeros(3))
    seen = condition_of(scaled, rung, may_agree_by_chance(scaled, rung), early, np.zeros(3))
    told = error_of(scaled, rung)
    assert error_felt(rung, np.inf) == 0.0 < told < accuracy < error_felt(rung, seen.condition)  # inf: a run failed
    assert 2 * accuracy < abs(first.ratio / true - 1)
    row = kernel.ke_ratio(*task, accuracy=accuracy)
    assert row.chaotic or abs(row.ke_ratio / true - 1) <= row.error <= accuracy


def test_an_error_told_by_looser_runs_counts_until_a_far_tighter_run_agrees_or_two_near_ones():
    _, x, pair = pair_at(EARLY)
    near, far = (Rung(pair, x, pair, x._replace(accuracy=times * x.accuracy)) for times in (NEAR, FAR))
    assert still_counts(2.0 * x.target, near) == pytest.approx(2.0 * x.target / NEAR)
    assert still_counts(100.0 * x.target, near) > x.target
    assert still_counts(still_counts(100.0 * x.target, near), near) < x.target
    assert still_counts(100.0 * x.target, far) < x.target
    assert still_counts(np.inf, far) == 0.0  # a run that failed told nothing


def test_where_dormand_prince_can_be_no_tighter_an_error_stays_what_was_told():
    """Its next refinement would be the same run, with which it agrees."""
    found = kernel.ke_ratio(33, 0.0, 4.740834997230297, 0.3969878752001459, accuracy=1e-8)
    assert not found.chaotic
    assert found.error > 2e-8


@pytest.mark.parametrize(("exponent", "jumps"), [(1.0, True), (1.1, True), (1.5, False), (2.0, False)])
def test_errors_are_not_taken_for_regular_where_the_stiffness_of_the_contact_jumps(exponent, jumps):
    lattice = Model(contact=kernel.Hertz(1e4, exponent)).lattice()
    assert has_a_jump(ScaledTask(12, 0.0, 0.1, 0.3, lattice, ())) == jumps
