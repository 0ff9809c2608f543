"""A certified scene says of every array how far it may be off: only the middle site's peak is as good as asked for."""

import math
import time

import numpy as np
import pytest

from kernel import Bistable, Drive, Impact, Model, Ramp, Scene, Simulation, simulate
from kernel.simulation import _errors

from . import scenes


def test_it_covers_the_errors_of_random_impacts():
    seed = time.time_ns() % 2**32
    found = np.array([scenes.measured(scene, (1e-2, 1e-4)) for scene in scenes.draw(30, seed, 40)])
    within = scenes.covers(found, scenes.NEARLY).mean(axis=0)
    assert within.min() > 0.85, f"{within} of seed {seed}"


def test_a_site_that_is_hit_again_is_told_to_be_less_accurate_than_asked_for():
    observe = {"ke_field": {"times": 41}, "peak_ke": {}}
    seen = simulate(Scene(26, 5.5e-5, Impact(0.58, 0.41), "linear", observe), 1e-3, certify=True)
    true = simulate(Scene(26, 5.5e-5, Impact(0.58, 0.41), "linear", observe), 1e-8)
    off = np.abs(seen["ke_field"]["ke"] - true["ke_field"]["ke"]).max() / true["ke_field"]["ke"].max()
    assert 1e-2 < off < 2 * seen.errors["ke_field"]["ke"]  # ten times the accuracy, and as much as is told
    assert abs(seen["peak_ke"]["ke"] / true["peak_ke"]["ke"] - 1) < seen.errors["peak_ke"]["ke"] < 1e-2


@pytest.mark.parametrize("event", [Impact(2.0, 2.0), Drive(Ramp(0.1, 0.5))])
def test_what_is_seen_is_the_same_as_without_and_its_work_is_counted(event):
    scene = Scene(12, 4e-3, event, observe={"profile": {"at": [0.5, 1.0]}})
    plain, certified = simulate(scene), simulate(scene, certify=True)
    assert all(np.array_equal(array, certified["profile"][key]) for key, array in plain["profile"].items())
    assert plain.errors == {}
    assert certified.errors["profile"]["site"] == 0.0 < certified.errors["profile"]["v"] < 0.1
    assert plain.steps < certified.steps < 2 * plain.steps
    assert plain.site_evaluations < certified.site_evaluations < 2 * plain.site_evaluations


def test_a_run_that_ended_early_has_no_errors():
    seen = simulate(Scene(12, 4e-3, Impact(2.0, 2.0), observe="profile"), certify=True, max_steps=50)
    assert seen.status != "done"
    assert np.isnan(seen.errors["profile"]["v"])


def test_where_all_of_an_array_is_0_it_is_right_or_infinitely_far_off():
    zero, one = (Simulation("done", "rk45", 1, 1, {"x": {"y": np.array([size])}}) for size in (0.0, 1.0))
    pairs = (zero, zero), (zero, one), (one, zero)
    assert [_errors(*pair)["x"]["y"] for pair in pairs] == [0.0, math.inf, 1.0]


def test_a_quantity_that_both_runs_have_as_0_has_no_known_error():
    """What weak dampers take, which is lost in the other energies, may be off by any factor."""
    model = Model(spring=Bistable(c2=4.2396277582257085, c3=3.4391029638643538))
    impact = Impact(0.016868288816570404, 2.1187386729972144)
    scene = Scene(7, 1.6967530073147332e-06, impact, observe={"dissipated": {}}, model=model)
    seen = simulate(scene, 1e-2, certify=True)
    assert seen["dissipated"]["value"] == 0.0
    assert math.isnan(seen.errors["dissipated"]["value"])


def test_certify_is_checked_beside_the_others():
    with pytest.raises(ValueError, match=r"accuracy: .*; certify: must be True or False, got 1"):
        simulate(Scene(12, 4e-3, Impact(2.0, 2.0), observe="profile"), accuracy=2.0, certify=1)
