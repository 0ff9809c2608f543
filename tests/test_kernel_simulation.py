"""Scenes: observers record what they promise, change nothing, and are built from checked options."""

import warnings

import numpy as np
import pytest

import kernel
from kernel import Drive, HalfSine, Impact, Model, Release, Scene, simulate
from kernel.laws.bistable import Bistable
from kernel.model import tension
from kernel.observers import OBSERVERS
from kernel.task import V0

IMPACT = Impact(M_over_M0=2.0, V_over_V0=2.0)
LIGHT_AND_STRONG = [4e-3, 0.1]  # zeta_T of the explicit and of the implicit splitting


def scene(*observe, N=30, zeta_T=4e-3, **more):
    return Scene(N, zeta_T, IMPACT, observe=observe, **more)


def test_the_peak_is_that_of_ke_ratio():
    task = kernel.ke_ratio(30, 4e-3, 2.0, 2.0, method="rk45", rtol=1e-6, atol=1e-9)
    for law in ("bistable", "linear"):
        peak = simulate(scene("peak_ke", law=law), method="rk45")["peak_ke"]
        assert peak["ke"] == pytest.approx(getattr(task, f"ke_{law}"), rel=1e-13)
        assert peak["t"] == pytest.approx(getattr(task, f"t_peak_{law}"), rel=1e-13)


@pytest.mark.parametrize("zeta_T", LIGHT_AND_STRONG)
def test_auto_takes_the_method_of_ke_ratio(zeta_T):
    task = kernel.ke_ratio(60, zeta_T, 2.0, 2.0, certify=False)
    seen = simulate(scene("peak_ke", "ke_field", N=60, zeta_T=zeta_T))
    assert seen.method == task.method != "rk45"
    assert seen["peak_ke"]["ke"] == pytest.approx(task.ke_bistable, rel=1e-13)
    assert seen["peak_ke"]["t"] == pytest.approx(task.t_peak_bistable, rel=1e-13)


@pytest.mark.parametrize(("zeta_T", "law"), [(4e-3, "bistable"), (0.1, "bistable"), (0.1, "linear")])
@pytest.mark.parametrize("method", ["auto", "rk45"])
def test_what_is_observed_does_not_change_the_steps(zeta_T, law, method):
    names = (*OBSERVERS, "wall_force")
    alone, crowd = (simulate(scene(*some, zeta_T=zeta_T, law=law), method=method) for some in (("peak_ke",), names))
    assert (crowd.method, crowd.steps, crowd.site_evaluations) == (alone.method, alone.steps, alone.site_evaluations)
    assert crowd["peak_ke"] == alone["peak_ke"]


@pytest.mark.parametrize(("zeta_T", "law"), [(4e-3, "bistable"), (1.0, "bistable"), (0.0, "linear"), (0.1, "linear")])
def test_both_ways_of_filming_come_to_show_the_same_chain(zeta_T, law):
    at = np.sort(np.random.default_rng(1).uniform(0.0, 1.0, 50))  # within steps, most of them
    asked = Scene(30, zeta_T, IMPACT, law, {"profile": {"at": [0.0, *at]}, "energy": {}}, kernel.Model(t_end=1.0))
    slow, *fast = simulate(asked, 1e-7, "rk45"), simulate(asked, 1e-3), simulate(asked, 1e-5)
    assert slow.method == "rk45" not in {seen.method for seen in fast}
    for name, key in (("profile", "u"), ("profile", "v"), ("energy", "total")):
        true = slow[name][key]
        loose, tight = (np.abs(seen[name][key] - true).max() / np.abs(true).max() for seen in fast)
        assert tight < 1e-3
        assert tight < 0.1 * loose


@pytest.mark.parametrize("zeta_T", LIGHT_AND_STRONG)
def test_a_frame_shows_the_same_whatever_else_is_filmed(zeta_T):
    few, many = (
        simulate(Scene(30, zeta_T, IMPACT, observe={"profile": {"at": at}}))["profile"]["u"]
        for at in ([1.0], np.linspace(0.0, 2.0, 401))
    )
    np.testing.assert_array_equal(few[0], many[200])


@pytest.mark.parametrize("method", ["auto", "rk45"])
def test_a_film_in_parts_is_the_film(monkeypatch, method):
    asked = Scene(30, 4e-3, IMPACT, observe={"profile": {"at": [0.1, 1.0, 2.0]}, "energy": {"times": 40}})
    whole = simulate(asked, method=method)
    monkeypatch.setattr(kernel.simulation, "FRAME_NUMBERS", 10 * 30)
    parts = simulate(asked, method=method)
    for name, key in (("profile", "v"), ("energy", "total"), ("energy", "dissipated")):
        np.testing.assert_array_equal(parts[name][key], whole[name][key])


def test_what_the_fast_methods_do_not_serve_is_done_by_rk45_and_says_so():
    disordered = kernel.Model(mass=kernel.Disordered(0.1, 1))
    assert simulate(scene("peak_ke", model=disordered)).method == "rk45"
    assert simulate(Scene(10, 4e-3, Drive(1e-2), observe="quasi_static")).method == "rk45"
    assert simulate(scene("peak_ke"), accuracy=1e-7).method == "rk45"


def test_nothing_that_was_not_asked_for_is_returned():
    assert set(simulate(scene("energy")).observed) == {"energy"}


def test_energy_and_what_the_dampers_took_add_up_to_the_impact_at_every_time():
    seen = simulate(scene("energy"), accuracy=1e-6, method="rk45")["energy"]
    np.testing.assert_allclose(seen["total"] + seen["dissipated"], 1.0, rtol=0, atol=1e-6)
    assert np.all(np.diff(seen["total"]) < 1e-7)
    assert seen["total"][0] == 1.0
    assert 0.5 < seen["dissipated"][-1] < 1.0


def test_the_field_at_the_middle_site_reaches_its_peak_and_a_coarse_field_misses_no_pulse():
    fine = simulate(Scene(30, 4e-3, IMPACT, observe={"peak_ke": {}, "ke_field": {"times": 4000}}))
    middle = fine["ke_field"]["ke"][:, (30 + 1) // 2 - 1]
    assert middle.max() == pytest.approx(fine["peak_ke"]["ke"], rel=1e-3)
    coarse = simulate(Scene(30, 4e-3, IMPACT, observe={"ke_field": {"times": 4000, "sites": 7}}))["ke_field"]
    assert coarse["ke"].shape == (4000, 7)
    assert coarse["site"].tolist() == [1, 5, 9, 13, 18, 22, 26]
    np.testing.assert_array_equal(coarse["ke"].max(axis=1), fine["ke_field"]["ke"].max(axis=1))


def test_viscous_force_and_profile_show_the_same_velocities():
    times = np.linspace(0, 2.25, 10)
    seen = simulate(
        Scene(
            30,
            4e-3,
            IMPACT,
            observe={"viscous_force": {"times": 10}, "profile": {"at": times}, "ke_field": {"times": 10}},
        )
    )
    v = seen["profile"]["v"]
    np.testing.assert_array_equal(seen["viscous_force"]["force"], 2 * 30 * 4e-3 * np.diff(v, append=0.0, axis=1))
    TE = 30 * 2 * 0.159 * (2 * V0) ** 2 / 2
    np.testing.assert_allclose(seen["ke_field"]["ke"], v**2 / 2 / TE)


def test_sites_ahead_of_the_wave_are_at_rest():
    v = simulate(Scene(100, 0.0, Impact(1.0, 0.5), "linear", {"profile": {"at": [0.25]}}))["profile"]["v"][0]
    assert np.abs(v[:20]).max() > 1e-2
    assert np.abs(v[60:]).max() < 1e-9


@pytest.mark.parametrize("N", [5, 20])
def test_a_slowly_driven_chain_follows_the_bulk_force_displacement_curve(N):
    """Figure A1: up to the first instability every cell has the strain of the whole chain, whatever N."""
    seen = simulate(Scene(N, 0.05, Drive(speed=2e-3, strain=0.1), observe=["quasi_static"]))["quasi_static"]
    bulk = np.array([-tension(Bistable(), -x) for x in seen["strain"]])
    settled = (seen["strain"] > 0.01) & (seen["strain"] < 0.09)  # the sudden start has died out by then
    assert settled.sum() > 250
    np.testing.assert_allclose(seen["force"][settled], bulk[settled], atol=0.004)


def test_a_held_end_is_pushed_with_what_changes_the_momentum_of_the_chain():
    """The whole chain's momentum changes by what moves the first site and by what the wall takes."""
    N, model, at = 12, Model(mass=[1.0 + 0.1 * k for k in range(12)], stiffness=2.0), np.linspace(0.0, 2.25, 4001)
    observe = {"quasi_static": {"times": 4001}, "viscous_force": {"times": 4001}, "profile": {"at": at}}
    seen = simulate(Scene(N, 0.02, Drive(HalfSine(0.05, 1.0), hold=True), model=model, observe=observe))
    force, v, u = seen["quasi_static"]["force"], seen["profile"]["v"], seen["profile"]["u"]
    wall = 2.0 * np.array([tension(Bistable(), -x) for x in u[:, -1]]) + seen["viscous_force"]["force"][:, -1]
    changes = np.gradient(v @ model.mass, at * N)
    smooth = (np.abs(at - 1.0) > 0.01) & (at > 0.01) & (at < 2.24)  # at 1 the site stops at once
    np.testing.assert_allclose(changes[smooth], (force + wall)[smooth], atol=2e-4)
    assert np.ptp(force) > 0.02


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"N": 1}, "N: must be a whole number"),
        ({"law": "cubic"}, "law: must be one of bistable, linear, got 'cubic'"),
        ({"N": 1, "event": (1, 1)}, r"N: .*; event: must be an Impact, a Drive or a Release, got \(1, 1\)"),
        ({"law": ["linear"]}, r"law: must be one of bistable, linear, got \['linear'\]"),
        ({"law": "Linear"}, r"got 'Linear' \(did you mean 'linear'\?\)"),
        ({"observe": ["peak", "energy"]}, r"observe: must be one of peak_ke, .*, got 'peak' \(did you mean 'peak_ke'"),
        (
            {"observe": {"energy": {"times": 0, "foo": 1}}},
            "observe: energy: has no option 'foo' .*; times must be a whole",
        ),
        ({"observe": 3}, "observe: must name at least one of peak_ke, .*, got 3"),
        ({"observe": np.array(3)}, r"observe: must name at least one of peak_ke, .*, got array\(3\)"),
        ({"observe": [["energy"]]}, r"observe: must be one of .*, got \['energy'\]"),
        ({"observe": {"ke_field": 400}}, r"observe: ke_field: its options \(times, sites\) must be a mapping, got 400"),
        ({"observe": {"ke_field": {"times": 10**6, "sites": 10**4}}, "N": 10**4}, "times x sites must be at most"),
        ({"observe": []}, "observe: must name at least one of peak_ke, "),
        (
            {"observe": {"ke_field": {"times": 1}}},
            "ke_field: times must be a whole number from 2 to 1000000, got 1",
        ),
        ({"observe": {"profile": {"at": [3.0]}}}, r"observe: profile: at must hold .* to 2.25, got \[3.0\]"),
        ({"observe": {"profile": {"at": "now"}}}, "observe: profile: at must hold .* got 'now'"),
        (
            {"observe": {"ke_field": {"time": 4}}},
            r"option 'time' \(there is times, sites\) \(did you mean 'times'",
        ),
        ({"observe": {"peak_ke": {"sites": 4}}}, r"observe: peak_ke: has no option 'sites' \(it has none\)"),
        ({"event": Drive(1e-2), "observe": ["energy"]}, "observe: energy: needs an impact, not a driven end"),
    ],
)
def test_a_bad_scene_is_refused_before_any_work(change, message):
    good = {"N": 10, "zeta_T": 1e-3, "event": IMPACT}
    with pytest.raises(ValueError, match=message):
        Scene(**(good | change))


@pytest.mark.parametrize(
    ("event", "message"),
    [
        (lambda: Impact(-1.0, 0.0), "M_over_M0: .*; V_over_V0: "),
        (lambda: Release([1e-200, 0], [0, 0]), "u, v: must not all be 0, or below 1e-100 in magnitude"),
        (lambda: Release([1e200, 0], ["0", 0]), "u: must hold numbers from -1e.06 to 1e.06, one for each site.*; v: "),
        (lambda: Drive(0.0), "speed: must be a finite number above 0, got 0.0"),
        (lambda: Drive(1e-3, "far"), "strain: must be a finite number above 0, got 'far'"),
    ],
)
def test_an_event_names_all_that_breaks_its_rules(event, message):
    with pytest.raises(ValueError, match=message):
        event()


def test_a_whole_number_may_come_as_any_number():
    given = Scene(30.0, 0, Impact(2, 2), observe={"ke_field": {"times": 4.0, "sites": np.int64(3)}})
    assert (given.N, type(given.N)) == (30, int)
    assert simulate(given)["ke_field"]["ke"].shape == (4, 3)


@pytest.mark.parametrize(("zeta_T", "method"), [(4e-3, "auto"), (4e-3, "rk45"), (0.1, "auto")])
def test_what_an_ended_run_has_not_seen_is_nan(zeta_T, method):
    observed = scene("energy", "profile", "peak_ke", "wall_force", zeta_T=zeta_T)
    seen = simulate(observed, method=method, max_steps=100)
    assert seen.status == "step_budget"
    assert np.isfinite(seen["energy"]["total"][0])
    assert np.isnan(seen["energy"]["total"][-1])
    assert np.isnan(seen["profile"]["v"]).all()
    assert np.isnan([seen["peak_ke"]["ke"], seen["wall_force"]["value"]]).all()


def test_a_budget_ends_a_run_after_a_whole_step_with_the_substeps_of_the_contact_in_it():
    """As the words on `max_steps` have it, of the explicit splitting."""
    assert "is asked for as a whole" in " ".join(simulate.__doc__.split())
    first = simulate(scene("energy", zeta_T=0.0), max_steps=1).steps
    within, beyond = (simulate(scene("energy", zeta_T=0.0), max_steps=first + more).steps for more in (0, 1))
    assert 1 < first == within < beyond


def test_a_driver_that_hardly_moves_ends_with_the_steps_that_it_was_given():
    seen = simulate(Scene(5, 1e-3, Drive(1e-9), observe="quasi_static"), max_steps=1000)
    assert (seen.status, np.isnan(seen["quasi_static"]["force"][-1])) == ("step_budget", True)


@pytest.mark.parametrize(("moved", "name", "largest"), [("v", "acceleration", 16.0), ("u", "wall_force", 0.1)])
def test_what_is_largest_when_a_chain_is_released_is_told(moved, name, largest):
    state = {"u": np.zeros(20), "v": np.zeros(20)}
    state[moved][9 if moved == "v" else 19] = 0.1
    seen = simulate(Scene(20, 0.1, Release(**state), law="linear", observe=name))[name]
    # Of a site at speed v between two at rest: 4 N zeta_T v N; of the last link at rest its strain.
    assert (seen["value"], seen["t"]) == (pytest.approx(largest, rel=1e-12), 0.0)


def test_a_held_end_that_starts_at_full_speed_is_felt_at_once_by_the_damper_behind_it():
    model = kernel.Model(site=0.2)
    seen = simulate(Scene(10, 0.1, Drive(0.05, hold=True), law="linear", observe="acceleration", model=model))
    assert float(seen["acceleration"]["value"]) >= 2 * 10 * 0.1 * 0.05 * 10 * (1 - 1e-12)


@pytest.mark.parametrize("method", ["auto", "rk45"])
def test_a_chain_that_breaks_ends_its_runs_long_before_their_step_budget(method):
    model, budget = kernel.Model(spring=kernel.Polynomial(2.0, 0.0)), 100_000
    row = kernel.ke_ratio(8, 1e-3, 1, 10, model=model, method=method, max_steps=budget)
    assert row.status in ("not_finite", "step_too_small")
    assert row.steps < budget


@pytest.mark.parametrize("size", [1e-100, 1e6])
def test_a_chain_is_released_from_whatever_state_is_not_refused_without_a_warning(size):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for event in (Release([size, 0.0], [0.0, 0.0]), Release([0.0, 0.0], [size, 0.0])):
            seen = simulate(Scene(2, 0.0, event, observe={"energy": {"times": 3}}), 0.1, max_steps=20000)
            assert seen["energy"]["total"][0] == pytest.approx(1.0)


def test_what_was_not_observed_is_asked_for_in_vain_with_a_hint():
    with pytest.raises(ValueError, match=r"observed: must be one of energy, got 'enrgy' \(did you mean 'energy'\?\)"):
        simulate(scene("energy"))["enrgy"]
    with pytest.raises(ValueError, match=r"accuracy: .*; scene: must be a Scene, got \(1, 2\)"):
        simulate((1, 2), accuracy=7)


@pytest.mark.parametrize("event", [Release([0.0] * 9 + [0.1], [0.0] * 10), Drive(HalfSine(0.05, 1.0), hold=True)])
@pytest.mark.parametrize("name", ["rebound", "impulse", "arrival", "contact_force"])
def test_what_an_impactor_does_is_not_told_of_a_chain_that_nobody_strikes(event, name):
    with pytest.raises(ValueError, match=f"observe: {name}: needs an impact"):
        Scene(10, 1e-3, event, observe=name)
    Scene(10, 1e-3, event, observe=["acceleration", "wall_force"])


def test_the_acceleration_of_a_site_that_is_held_is_not_told():
    """It is what the driver is told, and no force of the chain."""
    first = kernel.Model(site=1e-4)
    with pytest.raises(ValueError, match="acceleration: needs a site that moves freely"):
        Scene(10, 1e-3, Drive(HalfSine(0.05, 1.0), hold=True), observe="acceleration", model=first)
    Scene(10, 1e-3, Drive(HalfSine(0.05, 1.0)), observe="acceleration", model=first)


def test_a_profile_is_taken_at_the_runs_own_end_whatever_rounding_makes_of_it():
    for N in range(2, 200):
        for model in (Model(t_end=0.7), Model(mass=0.7)):
            asked = Scene(N, 0.0, IMPACT, observe={"profile": {"at": [0.1, model.t_end]}}, model=model)
            assert asked.observers()["profile"].times[-1] == pytest.approx(asked.t_end, rel=1e-12)
            assert asked.observers()["profile"].times[-1] <= asked.t_end
    at_end = Scene(3, 0.0, IMPACT, "linear", {"profile": {"at": 0.7}}, Model(t_end=0.7))
    assert np.isfinite(simulate(at_end)["profile"]["v"]).all()
    for late in ([0.7 * (1 + 1e-9)], [0.7, 0.7 * (1 + 1e-15)]):
        with pytest.raises(ValueError, match=r"at must hold increasing times over N from 0 to 0\.7"):
            Scene(3, 0.0, IMPACT, observe={"profile": {"at": late}}, model=Model(t_end=0.7))
