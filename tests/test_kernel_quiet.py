"""Runs that end early: sites that sound has not reached, and so few steps that parts of a run have none."""

import numpy as np
import pytest

import kernel
from kernel.crests import moved
from kernel.integrate import peak_of, told_by_modes
from kernel.ke import results_of
from kernel.method import MODES, at_accuracy, choose
from kernel.model import lattice_chain, linear_chain
from kernel.task import M0, V0
from kernel.watch import PARTS

pytestmark = pytest.mark.slow
# Of Dormand-Prince; velocities as small as 1e-20 of the impact's count here.
TIGHT = choose("rk45", rtol=1e-12, atol=1e-30)


def peaks(N, zeta_T, M, V, model, integrator):
    """Of both chains."""
    chains = (make(N, zeta_T, M * M0, model.lattice(N)) for make in (lattice_chain, linear_chain))
    return [peak_of(chain, V * V0, 0.0, integrator, (), False) for chain in chains]


def drawn(count, seed):
    """Random tasks whose run ends before sound has come to the watched site."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        N, site, share = int(rng.integers(4, 40)), rng.uniform(0.3, 1.0), rng.uniform(0.3, 0.95)
        M, V, zeta_T = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-5, -1)
        model = kernel.Model(t_end=share * site, site=site)
        both = peaks(N, zeta_T, M, V, model, TIGHT)
        if min(peak.run.speed for peak in both) > 1e-15 * V * V0:
            found.append(((N, zeta_T, M, V), model, both[0].KE / both[1].KE))
    return found


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3, 1e-4])
def test_a_site_that_sound_has_not_reached_is_calm_and_its_error_is_told(accuracy):
    covered, kept = [], []
    for task, model, true in drawn(30, int(1e6 * accuracy)):
        row = kernel.ke_ratio(*task, accuracy, model=model)
        assert not row.chaotic, task
        if row.status == "done":
            error = abs(row.ke_ratio / true - 1.0)
            covered.append(error <= row.error)
            kept.append(error <= accuracy)
    assert len(covered) >= 20
    assert np.mean(covered) >= 0.95
    assert np.mean(kept) >= 0.95


def test_what_modes_all_but_cancel_in_is_told_by_steps():
    """Modes of 36 sites add up to 1e-9 of the impact's speed where the site has 5e-11 of it."""
    task = 36, 6.27979850e-02, 1.37737959e-01, 4.84257504e-01
    model = kernel.Model(t_end=2.19989765e-02, site=5.65611334e-01)
    true = peaks(*task, model, TIGHT)[1]
    told = peaks(*task, model, at_accuracy(1e-4, choose("auto", 1e-4)))[1]
    assert told.method != MODES
    assert pytest.approx(true.KE, rel=1e-3) == told.KE
    chains = [linear_chain(36, 0.06, M0, kernel.Model(t_end=t_end).lattice(36)) for t_end in (0.49, 0.5)]
    assert [told_by_modes(chain, V0) for chain in chains] == [False, True]


def test_a_disturbed_run_of_a_quiet_site_is_disturbed_as_little_as_the_impact():
    columns = {"N": [50], "zeta_T": [1e-3], "M_over_M0": [1.0], "V_over_V0": [1.0]}
    columns = {name: np.array(values) for name, values in columns.items()}
    model = kernel.Model(t_end=0.7, site=1.0)
    here, there = (
        results_of(columns, choose("rk45", rtol=1e-10), False, size, model=model)["ke_ratio"][0] for size in (0.0, 1e-6)
    )
    assert 0.0 < abs(there / here - 1.0) < 1e-3


@pytest.mark.parametrize("t_end", [0.2, 0.35, 0.5, 0.8])
def test_a_run_of_few_steps_converges_without_many_more(t_end):
    """Parts in which no step began have no crest: the peak counted as gone, and five rungs were climbed in vain."""
    model, rng = kernel.Model(t_end=t_end), np.random.default_rng(int(100 * t_end))
    for _ in range(20):
        task = int(rng.integers(2, 5)), 10 ** rng.uniform(-6, -3), 10 ** rng.uniform(-1, 2), 10 ** rng.uniform(-2, 0)
        row = kernel.ke_ratio(*task, 1e-2, model=model)
        both = peaks(*task, model, TIGHT)
        assert row.status == "done", task
        assert row.ke_ratio == pytest.approx(both[0].KE / both[1].KE, rel=1e-2), task
        assert row.steps < 1500, task


def test_crests_that_moved_to_a_part_several_parts_away_are_the_same_crest():
    here, there = np.zeros(PARTS), np.zeros(PARTS)
    here[[0, 5, 11]], there[[0, 14]] = (1.0, 3.0, 10.0), (4.0, 10.5)
    assert moved(here, there, 3.0) == pytest.approx(0.05)
    there[13] = 7.0  # a part that has a crest is a neighbour, and no other beyond it
    assert moved(here, there, 3.0) == pytest.approx(0.3)
