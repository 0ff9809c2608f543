"""Chains whose first arrival wins: what comes later is stepped coarsely, and linear ones are run once."""

import numpy as np
import pytest

import kernel
from kernel.estimate import linear_error
from kernel.integrate import accuracy_afterwards
from kernel.lattice import PAPER_MODEL, Model
from kernel.laws import Hertz
from kernel.method import AFTERWARDS, EXPLICIT, IMPLICIT, choose, looser
from kernel.model import make_chain
from kernel.pairs import ScaledTask, beside, is_sure, pair_of
from kernel.quantities.wall_force import WallForce
from kernel.status import DONE
from kernel.task import M0, V0
from kernel.watch import new_watch
from tests.hasty import both_ways

EARLY = (40, 1e-3, 1.0, 1.0)  # the linear chain's crest of the first arrival wins by far
LATE = (81, 0.0, 0.863, 0.569)  # a crest after the reflection wins


def pair_at(task, accuracy=1e-3):
    N, zeta_T, M, V = task
    scaled = ScaledTask(N, zeta_T, M * M0, V * V0, PAPER_MODEL.lattice(), ())
    x = choose()._replace(accuracy=accuracy)
    return scaled, x, pair_of(scaled, x, np.zeros(3), False)


def test_a_linear_chain_is_run_once_where_the_first_arrival_wins_by_far():
    for task, again in ((EARLY, False), (LATE, True)):
        scaled, x, pair = pair_at(task)
        other, work = looser(x), np.zeros(3)
        beside_it = beside(scaled, pair, 0.0, other, work, False)
        both = pair_of(scaled, other, np.zeros(3), False)
        assert is_sure(scaled, pair.linear) != again
        assert (beside_it.linear.KE == pair.linear.KE) != again
        assert beside_it.bistable.KE == both.bistable.KE
        assert work[0] == both.bistable.run.steps + again * both.linear.run.steps


def test_no_linear_chain_is_sure_near_the_struck_end_or_where_the_contact_is_stiff_from_the_first_touch():
    scaled, _, pair = pair_at(EARLY)
    assert is_sure(scaled, pair.linear)
    for model in (Model(site=0.1), Model(contact=Hertz(exponent=1.0))):
        assert not is_sure(scaled._replace(lattice=model.lattice()), pair.linear)


@pytest.mark.parametrize(
    ("method", "bistable", "zeta_T", "saving"),
    [(EXPLICIT, False, (1e-6, 3e-3), 0.5), (EXPLICIT, True, (1e-6, 3e-3), 0.1), (IMPLICIT, True, (0.02, 1.0), 0.5)],
)
@pytest.mark.parametrize("accuracy", [1e-3, 3e-4, 3e-5])
def test_coarse_steps_after_the_first_arrival_change_no_peak(method, bistable, zeta_T, saving, accuracy):
    """A late crest that does not lose by far is told by fine steps, from when sound had crossed the chain."""
    rng, saved = np.random.default_rng(261181), []
    low, high = (12, zeta_T[0], 0.1, 0.1), (120, zeta_T[1], 10, 10)
    for task in (EARLY, LATE, *np.exp(rng.uniform(np.log(low), np.log(high), (60, 4)))):
        N, zeta, M, V = task
        chain = make_chain(round(N), max(zeta, zeta_T[0]), M, bistable=bistable)
        (fine, throughout), (hasty, crests) = both_ways(method, chain, V * V0, accuracy)
        assert hasty.status == fine.status == DONE
        assert (hasty.speed, hasty.t) == (fine.speed, fine.t), tuple(task)
        if hasty.steps > fine.steps:  # the coarse steps were lost, and what followed was as if there had been none
            assert (crests == throughout).all(), tuple(task)
        saved.append(hasty.steps < fine.steps)
    assert np.mean(saved) > saving
    if not bistable:
        assert saved[:2] == [True, False]


def test_steps_are_fine_throughout_where_more_than_the_peak_is_looked_at():
    N, zeta_T, M, _ = EARLY
    chain = make_chain(N, zeta_T, M, bistable=True)
    for accuracy in (3e-4, 3e-5):
        assert accuracy_afterwards(chain, accuracy, new_watch(())) == AFTERWARDS
        assert accuracy_afterwards(chain, accuracy, new_watch((WallForce(),))) == accuracy
        assert accuracy_afterwards(chain._replace(t_end=3.1 * N), accuracy, new_watch(())) == accuracy
    assert accuracy_afterwards(chain, 3e-2, new_watch(())) == 3e-2


# Stiff contacts, whose sharp crests coarse steps lose as they pass to and fro, and which win in the end.
@pytest.mark.parametrize(
    ("task", "t_end", "site", "stiffness"),
    [
        (
            (15, 5.229379344221323e-05, 16.81944296295747, 0.052214462350606804),
            7.532410882836252,
            0.7185,
            45372707.24764438,
        ),
        (
            (34, 1.9796393546168955e-05, 29.648333457651642, 7.983453428427587),
            14.541464534570297,
            0.677,
            6743.174478950343,
        ),
        ((14, 1.3437888881644e-05, 33.086877254545, 10.258039660368429), 7.761993596046164, 0.621, 196900.98069860434),
        ((15, 0.0, 3.5088521223459397, 3.0860511315431416), 5.07132307991233, 0.7246, 189668.0200033283),
    ],
)
def test_a_crest_that_wins_after_many_reflections_is_found(task, t_end, site, stiffness):
    model = Model(t_end=t_end, site=site, contact=Hertz(stiffness))
    found = kernel.ke_ratio(*task, accuracy=1e-4, model=model)
    tight = kernel.ke_ratio(*task, method="rk45", rtol=1e-10, certify=False, model=model)
    assert found.ke_ratio == pytest.approx(tight.ke_ratio, rel=1e-4)


@pytest.mark.parametrize("accuracy", [1e-3, 3e-4, 3e-5])
def test_a_linear_chain_that_is_run_once_is_within_the_error_stated_for_it(accuracy):
    """Nine in ten within it, none beyond five times."""
    rng, off = np.random.default_rng(11), []
    for _ in range(150):
        N, zeta_T, M, V = np.exp(rng.uniform(np.log((12, 1e-6, 0.1, 0.1)), np.log((120, 0.005, 10, 10)))).tolist()
        scaled, _, pair = pair_at((round(N), zeta_T, M, V), accuracy)
        if is_sure(scaled, pair.linear):
            tight = pair_at((round(N), zeta_T, M, V), 1e-7)[2].linear.KE
            off.append(abs(pair.linear.KE / tight - 1.0) / linear_error(accuracy))
    assert len(off) > 100
    assert np.quantile(off, 0.9) < 1.0
    assert max(off) < 5.0
