"""Two runs of the implicit splitting tell more than the better one: at every target, certified or not."""

import numpy as np
import pytest

import kernel
from kernel.extrapolate import extrapolated, first_of, is_regular
from kernel.lattice import PAPER_MODEL, Model
from kernel.laws import PiecewiseLinear
from kernel.method import AUTO, EXTRAPOLATED, IMPLICIT, RK45, choose, looser
from kernel.pairs import Rung, ScaledTask, pair_of
from kernel.quantities.last import Flipped, Stored
from kernel.task import M0, V0

LATTICE = PAPER_MODEL.lattice()


def task(N, zeta_T, M=1.0, V=1.0, lattice=LATTICE):
    """M and V over the nominal ones."""
    return ScaledTask(N, zeta_T, M * M0, V * V0, lattice, ())


def rung(its, accuracy):
    x = choose("auto", 1e-3)._replace(accuracy=accuracy)
    return Rung(*(part for y in (x, looser(x)) for part in (pair_of(its, y, np.zeros(3), False), y)))


def drawn(count, seed):
    """Chains whose dampers are strong, short enough for a tight Dormand-Prince."""
    rng = np.random.default_rng(seed)
    N = rng.integers(10, 60, count)
    zeta_T = 10 ** rng.uniform(0, 1.5, count) / N
    return {
        "N": N,
        "zeta_T": zeta_T,
        "M_over_M0": 10 ** rng.uniform(-1, 1, count),
        "V_over_V0": rng.uniform(0.2, 4, count),
    }


@pytest.fixture(scope="module")
def tasks():
    return drawn(24, 11)


@pytest.fixture(scope="module")
def true(tasks):
    return kernel.ke_ratios(tasks, method="rk45", rtol=1e-11, atol=1e-14, certify=False)["ke_ratio"]


@pytest.mark.parametrize(("accuracy", "nearer"), [(1e-4, 20.0), (1e-5, 50.0)])
def test_what_two_runs_tell_is_far_nearer_to_the_truth_than_the_better_one(tasks, true, accuracy, nearer):
    off, left = [], []
    for values, ratio in zip(zip(*tasks.values(), strict=True), true, strict=True):
        its = task(*(value.item() for value in values))
        runs = rung(its, accuracy)
        if runs.best.bistable.method == IMPLICIT:
            both = extrapolated(its, runs).bistable.KE / rung(its, 1e-7).best.linear.KE
            alone = runs.best.bistable.KE / rung(its, 1e-7).best.linear.KE
            off.append(abs(alone / ratio - 1.0))
            left.append(abs(both / ratio - 1.0))
    assert len(off) >= 8
    assert np.median(np.array(off) / np.array(left)) > nearer
    assert max(left) < accuracy


def test_quantities_are_extrapolated_as_the_energy_is():
    its = task(100, 0.3)
    runs = rung(its, 1e-5)
    told = runs._replace(
        **{
            name: pair._replace(bistable=pair.bistable._replace(largest=np.array([pair.bistable.KE, 3.0])))
            for name, pair in (("best", runs.best), ("against", runs.against))
        }
    )
    found = extrapolated(its._replace(quantities=(Stored(), Stored())), told).bistable
    assert found.KE != runs.best.bistable.KE
    assert found.largest == pytest.approx([found.KE, 3.0], rel=1e-14)
    counted = extrapolated(its._replace(quantities=(Flipped(), Stored())), told).bistable
    assert counted.largest.tolist() == [runs.best.bistable.KE, 3.0], "links are counted, and no share of one is flipped"


@pytest.mark.parametrize("target", [1e-4, 1e-6, 1e-8])
def test_every_target_is_reached_with_an_error_that_covers_and_no_chaos(tasks, true, target):
    rows = kernel.ke_ratios(tasks, target)
    off = np.abs(rows["ke_ratio"] / true - 1.0)
    assert (rows["status"] == "done").all()
    assert (off <= np.maximum(target, 1e-9)).all()  # of the reference 1e-9 is believed
    assert np.mean(off <= np.maximum(rows["error"], 1e-9)) > 0.95
    assert not rows["chaotic"].any()


def test_stiff_dampers_are_implicit_at_the_tightest_target_and_spare_most_of_the_work():
    """Dormand-Prince takes eight times the evaluations here, for one run of each chain."""
    its = {"N": 100, "zeta_T": 1.0, "M_over_M0": 1.0, "V_over_V0": 1.0}
    row, tight = (
        kernel.ke_ratio(**its, accuracy=1e-7),
        kernel.ke_ratio(**its, accuracy=1e-7, method="rk45", certify=False),
    )
    assert (row.method, row.status) == ("implicit", "done")
    assert row.ke_ratio == pytest.approx(tight.ke_ratio, rel=1e-7)
    assert 5.0 * row.site_evaluations < tight.site_evaluations


def test_a_plain_row_is_extrapolated_as_a_certified_one():
    its = {"N": 60, "zeta_T": 0.05, "M_over_M0": 1.0, "V_over_V0": 1.0}
    certified, plain = (kernel.ke_ratio(**its, accuracy=1e-4, certify=certify) for certify in (True, False))
    assert certified.method == "implicit"
    assert plain.ke_ratio == certified.ke_ratio
    assert plain.ke_ratio == plain.ke_bistable / plain.ke_linear
    assert plain.steps < certified.steps + 1
    assert np.isnan(plain.error)


def test_a_task_begins_looser_only_where_its_runs_will_be_extrapolated():
    """Not at coarse targets, with weak dampers, nor where the stiffness jumps."""
    strong, weak = task(100, 0.1), task(100, 1e-4)
    jumps = task(100, 0.1, lattice=Model(spring=PiecewiseLinear((0.1, 0.3), (-0.5, 2.0))).lattice())
    at = choose("auto", 1e-5)
    assert first_of(strong, at).accuracy == pytest.approx(np.sqrt(1e-5 * EXTRAPOLATED))
    assert first_of(strong, choose("auto", 1e-3)).accuracy == pytest.approx(3e-4)
    assert first_of(strong, choose("auto", 2e-4)).accuracy == EXTRAPOLATED
    near = task(100, 0.1, lattice=Model(site=0.2).lattice())  # whose linear chain the modes do not tell
    assert [first_of(its, at).accuracy for its in (weak, jumps, near)] == [at.accuracy] * 3
    tight = choose("auto", 1e-7)
    assert [first_of(its, tight).kind for its in (strong, weak, jumps)] == [AUTO, RK45, AUTO]


def test_the_explicit_splitting_serves_weak_dampers_to_a_target_of_1e_6_also_where_stiffness_jumps():
    law = Model(spring=PiecewiseLinear((0.1, 0.3), (-0.5, 2.0))).lattice()
    smooth, jumps = task(100, 1e-4), task(100, 1e-4, lattice=law)
    for its in (smooth, jumps):
        assert [first_of(its, choose("auto", target)).kind for target in (1e-6, 1e-7)] == [AUTO, RK45]


def test_runs_are_not_extrapolated_where_their_errors_do_not_follow_the_rule():
    strong, weak = task(100, 0.1), task(100, 1e-4)
    fine, coarse, explicit = rung(strong, 3e-5), rung(strong, 3e-4), rung(weak, 3e-5)
    run = fine.best.bistable.run._replace(retries=1)
    again = fine._replace(best=fine.best._replace(bistable=fine.best.bistable._replace(run=run)))
    assert [is_regular(its, r) for its, r in ((strong, fine), (strong, coarse), (weak, explicit), (strong, again))] == [
        True,
        False,
        False,
        False,
    ]
    for its, r in ((strong, coarse), (weak, explicit), (strong, again)):
        assert extrapolated(its, r).ratio == r.best.ratio
