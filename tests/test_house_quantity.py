"""A quantity from outside of the kernel, stated once, runs through every integrator and through a scene."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kernel
from kernel.ke import results_of
from kernel.method import choose
from kernel.model import M0, V0, link_force, make_chain
from kernel.quantities import QUANTITIES, WallForce

from . import twin


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
    task = (8, zeta_T, 2.0, 2.0)
    columns = {name: np.array([value]) for name, value in zip(kernel.ke.PARAMETERS, task, strict=True)}
    integrator = choose("rk45", rtol=1e-8) if method == "rk45" else choose("auto", 1e-4)
    asked = {"momentum": Momentum(), "wall_force": WallForce()}
    (row,) = results_of(columns, integrator, certify=True, quantities=asked)
    true = {"": true_largest(*task, True), "_linear": true_largest(*task, False)}
    for k, name in enumerate(asked):
        for chain in ("", "_linear"):
            assert row[name + chain] == pytest.approx(true[chain][k], rel=1e-3), (name, chain)
        ratio = true[""][k] / true["_linear"][k]
        assert row[f"{name}_ratio"] == pytest.approx(ratio, rel=max(row[f"{name}_error"], 1e-5))


def test_a_quantity_from_outside_is_observed_in_a_scene(momentum):
    scene = kernel.Scene(8, 1e-3, kernel.Impact(2.0, 2.0), observe=("momentum", "wall_force", "energy"))
    seen = kernel.simulate(scene, 1e-5)
    largest = seen["momentum"]["largest"], seen["wall_force"]["largest"]
    assert largest == pytest.approx(true_largest(8, 1e-3, 2.0, 2.0, True), rel=1e-4)
    assert 0 < seen["momentum"]["t"] < 2.25
