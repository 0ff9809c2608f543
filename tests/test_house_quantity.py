"""A quantity from outside, stated once, runs through every integrator, a scene, a sweep's table, a map."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis.strategies import floats
from scipy.integrate import solve_ivp

import analysis
import kernel
from analysis.cli import main as analysis_command
from kernel import rk45
from kernel.columns import RESULT, columns_of_quantity
from kernel.integrate import run_by
from kernel.ke import results_of
from kernel.method import IMPLICIT, choose
from kernel.model import link_force, make_chain
from kernel.observers import OBSERVERS
from kernel.quantities import QUANTITIES, WallForce
from kernel.task import M0, V0
from kernel.watch import FOUND, is_far_below, keep_largest, largest_of, new_watch
from sweep.cli import main as sweep_command

from . import twin

pytestmark = pytest.mark.slow


class Momentum(NamedTuple):
    """Largest momentum of the chain, without the impactor, over the impactor's at first."""

    def unit(self):
        return "N m_T V"

    def value(self, chain, view):
        total = 0.0
        for i in range(1, chain.N + 1):
            total += view.velocity(i)
        return total

    def slope(self, chain, view):
        return link_force(chain, view, chain.N) - link_force(chain, view, 0)

    def scale(self, chain, V):
        return chain.impactor_mass * V

    def sees_impactor(self):
        return True  # the push of the impactor is what changes it


ASKED = {"momentum": Momentum(), "wall_force": WallForce()}  # nearly everywhere: others are compiled anew


@pytest.fixture
def momentum(monkeypatch):
    monkeypatch.setitem(QUANTITIES, "momentum", Momentum())


def true_largest(N, zeta_T, M, V, bistable):
    """Momentum and wall force by scipy, from the equations of tests/twin.py alone."""
    chain, V = make_chain(N, zeta_T, M, bistable=bistable), V * V0
    start = np.zeros(2 * N + 2)
    start[N + 1] = V
    seen = solve_ivp(
        lambda _, y: np.concatenate([y[N + 1 :], twin.acceleration(chain, y[: N + 1], y[N + 1 :])]),
        (0.0, 2.25 * N),
        start,
        "DOP853",
        rtol=1e-9,
        atol=1e-12,
        max_step=0.01,
    )
    momentum = seen.y[N + 2 :].sum(axis=0) / (N * M * M0 * V)
    strain, slip = -seen.y[N], -seen.y[-1]
    force = np.array([twin.spring_force(*chain.spring, e) for e in strain]) + 2.0 * chain.zeta * slip
    return np.abs(momentum).max(), np.abs(force).max()


@pytest.mark.parametrize(("zeta_T", "method"), [(1e-3, "explicit"), (0.08, "implicit"), (0.08, "rk45")])
def test_a_quantity_from_outside_is_found_by_every_integrator_for_both_chains(zeta_T, method):
    task = (10, zeta_T, 2.0, 2.0)
    columns = {name: np.array([value]) for name, value in zip(kernel.ke.PARAMETERS, task, strict=True)}
    integrator = choose("rk45", rtol=1e-8) if method == "rk45" else choose("auto", 1e-4)
    (row,) = results_of(columns, integrator, certify=True, quantities=ASKED)
    # One that sees the impactor is told by Dormand-Prince, and all beside it; alone, the last link is told by `method`.
    (alone,) = results_of(columns, integrator, certify=True, quantities=QUANTITIES)
    true = {"": true_largest(*task, True), "_linear": true_largest(*task, False)}
    for name, k, found in (("momentum", 0, row), ("wall_force", 1, row), ("wall_force", 1, alone)):
        for chain in ("", "_linear"):
            assert found[name + chain] == pytest.approx(true[chain][k], rel=1e-3), (name, chain)
        ratio = true[""][k] / true["_linear"][k]
        assert found[f"{name}_ratio"] == pytest.approx(ratio, rel=max(found[f"{name}_error"], 1e-5))


def test_what_is_observed_changes_nothing_that_is_known_of_ke_ratio():
    """Where dampers are strong too, although the linear chain's modes tell no quantity."""
    tasks = {"N": [8, 20, 30, 8, 20, 30], "zeta_T": [1e-3, 1e-4, 0.0, 0.08, 0.1, 0.5]}
    columns = {name: np.array(values) for name, values in tasks.items()}
    columns |= {"M_over_M0": np.full(6, 2.0), "V_over_V0": np.linspace(1.0, 6.0, 6)}
    seen, alone = (results_of(columns, choose("auto", 1e-4), certify=True, quantities=q) for q in (QUANTITIES, {}))
    for name in alone.dtype.names:
        if name not in ("steps", "evaluations", "site_evaluations"):
            assert seen[name].tobytes() == alone[name].tobytes(), name
    more = seen["site_evaluations"] > alone["site_evaluations"]
    assert more.tolist() == [True, False, False, True, True, True]  # that of the fourth site by Dormand-Prince


@given(shift=floats(0.0, 6.0), ratio=floats(1.1, 3.0), h=floats(0.02, 0.2))
def test_crests_are_found_without_the_slopes_that_are_far_below_them(shift, ratio, h):
    t = np.arange(0.0, 20.0, h)
    f, slope = np.sin(t) + 0.5 * np.sin(ratio * t + shift), np.cos(t) + 0.5 * ratio * np.cos(ratio * t + shift)
    lazy, all_known, asked = np.zeros(5), np.zeros(5), 0
    for memory in (lazy, all_known):
        memory[:2] = f[0], slope[0]
    for k in range(1, len(t)):
        low = is_far_below(lazy, f[k])
        asked += not low
        for memory, rate in ((lazy, np.nan if low else slope[k]), (all_known, slope[k])):
            keep_largest(memory, t[k - 1], h, f[k], rate)
            memory[:2] = f[k], rate
    assert lazy[FOUND] == all_known[FOUND]
    assert asked < len(t) - 1


@pytest.mark.parametrize("N", [15, 16, 31, 32, 33])
def test_the_last_link_ends_at_the_wall_however_the_chain_is_packed(N):
    chain, V, watches = (
        make_chain(N, 0.08, 2.0, bistable=True),
        2.0 * V0,
        [new_watch(tuple(ASKED.values())) for _ in range(2)],
    )
    run_by(IMPLICIT, chain, V, 0.0, 1e-4, 10**7, watches[0])
    rk45.integrate(chain, V, 1e-9, 1e-12, 10**8, 2.25 * N, watches[1])
    fast, slow = (largest_of(watch, chain, V)[1] for watch in watches)
    assert fast == pytest.approx(slow, rel=2e-3)


def test_a_quantity_of_a_run_that_failed_has_no_numbers_and_its_name_is_nobody_elses():
    columns = {name: np.array([value]) for name, value in zip(kernel.ke.PARAMETERS, (30, 1e-3, 1.0, 1.0), strict=True)}
    (row,) = results_of(columns, choose("auto", 1e-3, max_steps=50), certify=True, quantities=ASKED)
    assert row["status"] == "step_budget"
    assert all(np.isnan(row[name]) for name in columns_of_quantity("wall_force"))
    (row,) = results_of(columns, choose("auto", 1e-3), certify=False, quantities=ASKED)
    assert np.isfinite(row["wall_force_ratio"])
    assert np.isnan(row["wall_force_error"])
    taken = {*RESULT.names, *OBSERVERS, "ke"}
    assert not {name for quantity in QUANTITIES for name in columns_of_quantity(quantity)} & taken


@pytest.mark.parametrize(("method", "within"), [("auto", 1e-3), ("rk45", 1e-4)])  # auto: as well as tables have it
def test_a_quantity_from_outside_is_observed_in_a_scene(momentum, method, within):
    scene = kernel.Scene(10, 1e-3, kernel.Impact(2.0, 2.0), observe=("momentum", "wall_force", "energy"))
    seen = kernel.simulate(scene, 1e-5, method)
    largest = seen["momentum"]["value"], seen["wall_force"]["value"]
    assert largest == pytest.approx(true_largest(10, 1e-3, 2.0, 2.0, True), rel=within)
    assert seen.method == "rk45"  # as it sees the impactor
    assert 0 < seen["momentum"]["t"] < 2.25


SPEC = """
name = "pushes"
[grid]
N = [6, 9]
zeta_T = [1e-3, 0.1]
M_over_M0 = [1, 2]
V_over_V0 = [1]
[accuracy]
target = 1e-3
[output]
observe = ["peak_ke", "momentum", "wall_force"]
"""
COLUMNS = [column for name in ASKED for column in columns_of_quantity(name)]


def test_a_quantity_from_outside_has_its_columns_in_a_table_in_exports_and_on_a_map(momentum, tmp_path, capsys):
    spec, path = tmp_path / "pushes.toml", tmp_path / "t.h5"
    spec.write_text(SPEC)
    assert sweep_command(["run", str(spec), "-o", str(path)]) == 0
    df = analysis.load(path)
    columns = {name: df[name].to_numpy(float) for name in kernel.ke.PARAMETERS}
    rows = results_of(columns, choose("auto", 1e-3), certify=True, quantities=ASKED)
    for name in COLUMNS:
        assert df[name].to_numpy().tobytes() == rows[name].tobytes()
    assert df["momentum_ratio"].between(0.1, 10).all()
    assert sweep_command(["export", str(path), "-o", str(tmp_path / "t.csv")]) == 0
    assert pd.read_csv(tmp_path / "t.csv")[COLUMNS].to_numpy() == pytest.approx(df[COLUMNS].to_numpy(), rel=1e-15)
    at = ["--at", "M_over_M0=2", "V_over_V0=1"]
    assert analysis_command(["map", str(path), "-o", str(tmp_path / "m.png"), "--of", "momentum_ratio", *at]) == 0
    assert "momentum" in capsys.readouterr().out


def test_tables_of_one_quantity_are_resumed_shared_out_and_merged_and_others_are_refused(momentum, tmp_path, capsys):
    spec = tmp_path / "pushes.toml"
    spec.write_text(SPEC)
    whole, parts = tmp_path / "t.h5", [tmp_path / f"{k}.h5" for k in (1, 2)]
    for k, part in enumerate(parts, 1):
        assert sweep_command(["run", str(spec), "-o", str(part), "--shard", f"{k}/2"]) == 0
    assert sweep_command(["merge", *map(str, parts), "-o", str(whole)]) == 0
    assert analysis.load(whole)[COLUMNS].notna().all(axis=None)
    again = tmp_path / "again.h5"
    assert sweep_command(["run", str(spec), "-o", str(again), "--reuse", str(whole)]) == 0
    assert "8 rows taken" in capsys.readouterr().err
    spec.write_text(SPEC.replace(', "momentum", "wall_force"', ""))
    assert sweep_command(["run", str(spec), "-o", str(tmp_path / "b.h5"), "--reuse", str(whole)]) == 2
    assert "has the quantities momentum, wall_force, wanted none" in capsys.readouterr().err
    assert sweep_command(["run", str(spec), "-o", str(whole)]) == 2
    spec.write_text(SPEC.replace("momentum", "momentun"))
    assert sweep_command(["run", str(spec), "-o", str(tmp_path / "c.h5")]) == 2
    assert "(did you mean 'momentum'?)" in capsys.readouterr().err
