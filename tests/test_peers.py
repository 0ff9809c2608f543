"""The benchmark's peers solve our equations: independent codes, other languages and unknowns, one answer."""

import numpy as np
import pytest

import kernel
from kernel.model import chain_of
from kernel.task import M0, V0

from . import exact
from .peers import cvode, laws, octave, odeint, reference, scipy_peers, table
from .peers.common import TARGETS, TASKS, Missing, Point, Task, neighbours, reached
from .peers.force import crest
from .promises import LAWS

pytestmark = pytest.mark.slow

SMALL = [Task(10, 1e-3, 1.0, 1.0), Task(11, 0.0, 0.5, 2.0)]
# (peer, tolerance, agreement): CVODE controls the local error only, Octave knows its steps only.
PEERS = [(scipy_peers, 1e-8, 1e-5), (odeint, 1e-8, 1e-5), (cvode, 1e-8, 1e-3), (octave, 1e-5, 1e-2)]


@pytest.mark.parametrize(("peer", "rtol", "agreement"), PEERS, ids=lambda x: getattr(x, "__name__", None))
def test_every_solver_of_a_peer_agrees_with_ours(peer, rtol, agreement):
    ours = [kernel.ke_ratio(**vars(task), method="rk45", rtol=1e-10, certify=False).ke_ratio for task in SMALL]
    try:
        solvers = peer.solvers()
    except Missing as reason:
        pytest.skip(str(reason))
    for solver in solvers:
        ratios, seconds = solver.run(SMALL, rtol)
        assert ratios == pytest.approx(ours, rel=agreement), solver.name
        assert seconds > 0


@pytest.mark.parametrize("name", LAWS)
def test_the_compiled_peer_has_the_springs_that_we_have(name):
    chain = chain_of(9, 2e-3, 2.0 * M0, LAWS[name])
    true = exact.largest(exact.run(chain, 2.0 * V0, 1e-9), lambda y: y[chain.N + 1 + chain.site])
    try:
        theirs = odeint.peak_speed(Task(9, 2e-3, 2.0, 2.0), 1e-9, 1e-11, LAWS[name], laws.FLAGS)
    except Missing as reason:
        pytest.skip(str(reason))
    assert theirs == pytest.approx(true, rel=1e-6)


def test_the_compiled_peer_leaves_subnormal_numbers_to_us():
    try:
        odeint.ke_ratio(SMALL[0], 1e-4, 1e-7)
    except Missing as reason:
        pytest.skip(str(reason))
    assert np.float64(5e-324) * np.float64(1.0) > 0.0
    assert np.all(np.full(9, 1e-310) * 0.5 > 0.0)


def test_the_stored_reference_is_that_of_the_tasks():
    stored = reference.load()
    assert set(stored) == set(TASKS)
    for name in "AD":
        for index, ratio in list(stored[name].items())[:2]:
            assert reference.converged(neighbours(name)[index], 1e-8) == pytest.approx(ratio, rel=1e-4)


def test_neighbours_are_seeded_and_within_five_percent():
    batch = neighbours("B")
    assert batch == neighbours("B")
    assert batch[0] == TASKS["B"]
    assert len(set(batch)) == 64
    assert all(abs(task.V_over_V0 / 10.0 - 1.0) <= 0.05 and task.N == 200 for task in batch)


@pytest.mark.parametrize("seed", range(20))
def test_the_crest_is_where_the_cubic_is_largest_inside_the_step(seed):
    v0, a0, v1, a1 = np.random.default_rng(seed).normal(size=4)
    h, x = 0.7, np.linspace(0.0, 1.0, 10001)
    cubic = v0 * (1 + 2 * x) * (1 - x) ** 2 + v1 * x**2 * (3 - 2 * x) + h * x * (1 - x) * (a0 * (1 - x) - a1 * x)
    top = np.argmax(np.abs(cubic))
    found = crest(v0, a0, v1, a1, h, 0.0)
    if 0 < top < len(x) - 1:
        assert found == pytest.approx(x[top], abs=2e-4)
    assert crest(v0, a0, v1, a1, h, 1.1 * max(1.0, *np.abs([v0, v1, v0 + h * a0 / 3, v1 - h * a1 / 3]))) == -1.0


def test_the_error_reached_leaves_out_the_worst_tenth_only_and_never_a_failure_of_few():
    exact = np.ones(16)
    assert reached(exact + np.r_[np.full(15, 1e-3), 1.0], exact) == pytest.approx(1e-3)
    assert reached(exact + np.r_[np.full(14, 1e-3), 0.5, 1.0], exact) == pytest.approx(0.5)
    assert reached(np.array([1.0, np.nan, 1.0]), np.ones(3)) == np.inf


def test_the_table_takes_the_fastest_setting_that_reaches_the_target():
    def point(solver, setting, error, seconds):
        return Point(solver, "A", setting, error, seconds, 3, 3, 1)

    points = [
        point("peer", 1e-3, 5e-3, 1.0),
        point("peer", 1e-4, 2e-4, 4.0),
        point("peer", 1e-5, 9e-4, 3.0),
        point(table.BATCHED, 1e-3, 1e-5, 0.5),
    ]
    assert [table.best(points, "peer", "A", target).setting for target in TARGETS[:2]] == [1e-3, 1e-5]
    assert table.best(points, "peer", "A", TARGETS[2]) is None
    assert table.ratio(points, "peer", "A", 1e-3, table.BATCHED) == 6.0
    assert table.ratio(points, "peer", "A", 1e-4, table.BATCHED) is None
    assert "6 (A)" in table.text(points, ["a header"])
