"""Screening shares what hardly depends on the impact's speed: the linear chain's answer over the impact's energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kernel.ke import results_of
from kernel.method import SHARED_SPEED_RATIO, choose, shared_speed

COARSE = choose("auto", 0.1, certify=False)
SPEEDS = np.geomspace(0.1, 10.0, 9)


def columns(zeta_T=1e-4):
    """Two chains, two masses and all speeds, shuffled."""
    N, M, V = (x.ravel() for x in np.meshgrid([9, 30], [0.2, 3.0], SPEEDS, indexing="ij"))
    order = np.random.default_rng(3).permutation(len(N))
    return {"N": N[order], "zeta_T": np.full(len(N), zeta_T), "M_over_M0": M[order], "V_over_V0": V[order]}


@given(st.floats(1e-2, 20.0))
def test_a_shared_speed_is_no_further_away_than_half_way_to_the_next(V):
    far = max(shared_speed(V) / V, V / shared_speed(V))
    assert far <= SHARED_SPEED_RATIO**0.5 * (1 + 1e-12)
    assert shared_speed(shared_speed(V)) == pytest.approx(shared_speed(V), rel=1e-15)


@pytest.mark.parametrize("zeta_T", [0.0, 1e-4, 0.3])
@pytest.mark.parametrize("until", [1.5, np.inf])
def test_only_the_linear_chain_is_that_of_another_speed(zeta_T, until):
    tasks = columns(zeta_T)
    shared = results_of(tasks, COARSE, False, until=until, shared=True)
    own = results_of(tasks, COARSE, False, until=until)
    near = results_of(tasks | {"V_over_V0": shared_speed(tasks["V_over_V0"])}, COARSE, False, until=until)
    for name in ("ke_bistable", "t_peak_bistable", "method", "status", "V_over_V0"):
        assert np.array_equal(shared[name], own[name])
    for name in ("ke_linear", "t_peak_linear"):
        assert np.array_equal(shared[name], near[name])
    assert np.array_equal(shared["ke_ratio"], shared["ke_bistable"] / shared["ke_linear"])
    assert np.abs(np.log(shared["ke_linear"] / own["ke_linear"])).max() < 0.05
    assert np.isnan(shared["error"]).all()
    assert not shared["checked"].any()


def test_a_row_is_the_same_whatever_is_screened_beside_it():
    tasks = columns()
    whole = results_of(tasks, COARSE, False, shared=True)
    for part in (slice(0, 1), slice(5, 20), slice(None, None, 3)):
        some = results_of({name: values[part] for name, values in tasks.items()}, COARSE, False, shared=True)
        for name in ("ke_ratio", "ke_linear", "t_peak_linear", "status"):
            assert np.array_equal(some[name], whole[part][name])


def test_a_linear_chain_is_run_once_for_all_that_share_it():
    tasks = columns()
    shared, own = (results_of(tasks, COARSE, False, until=0.1, shared=x) for x in (True, False))
    groups = {tuple(x) for x in zip(tasks["N"], tasks["M_over_M0"], shared_speed(tasks["V_over_V0"]), strict=True)}
    saved = 1.0 - shared["site_evaluations"].sum() / own["site_evaluations"].sum()
    assert saved == pytest.approx(1.0 - len(groups) / len(own), rel=0.1)  # of the chain itself hardly anything is run
    assert results_of({name: x[:0] for name, x in tasks.items()}, COARSE, False, shared=True).shape == (0,)


def test_a_run_that_fails_takes_its_number_away_and_those_of_others_not():
    tasks = columns()
    failed = results_of(tasks, COARSE._replace(max_steps=150), False, shared=True)
    assert 0 < np.sum(failed["status"] == "step_budget") < len(failed)
    assert np.array_equal(np.isnan(failed["ke_ratio"]), failed["status"] == "step_budget")
