"""Accuracy, order, exactness, guards and work of the splitting integrators."""

import itertools
import json
import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from kernel import Hertz, Model, ke_ratio, rk45
from kernel.integrate import run_by
from kernel.jit import FASTMATH
from kernel.laws.any_power import AnyPower
from kernel.laws.bistable import Bistable
from kernel.laws.hertz import ThreeHalves
from kernel.laws.power import PowerLaw
from kernel.laws.toda import Toda
from kernel.maxima import cubic_crest, quintic_crest
from kernel.method import AFTERWARDS, EXPLICIT, IMPLICIT, SWITCH
from kernel.model import M0, V0, Chain, energy, make_chain
from kernel.simd import DOUBLE, SINGLE
from kernel.splitting import (
    coefficients,
    damped,
    explicit,
    implicit,
    lanes,
    rules,
    sweeps,
    zone,
)
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET
from kernel.watch import new_watch

LAWS = ("bistable", "linear")
LINEAR = Bistable(0.0, 0.0)


def peak(N, zeta_T, M, V, accuracy=1e-3, law="bistable", max_steps=10**8, K=None):
    """A task in the paper's ratios by a splitting; the run and the peak energy over the initial one."""
    chain = make_chain(N, zeta_T, M, bistable=law == "bistable")
    chain = chain if K is None else chain._replace(contact=ThreeHalves(K))
    method = EXPLICIT if chain.zeta < SWITCH else IMPLICIT
    out = run_by(method, chain, V * V0, 0.0, accuracy, max_steps, new_watch(()))
    return out, out.speed**2 / (N * M * M0 * (V * V0) ** 2)


def random_tasks(count, seed, largest):
    """Log-uniform in the paper's domain, one in four undamped."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        N = int(np.exp(rng.uniform(np.log(2), np.log(largest + 1))))
        zeta_T, M, V = 10 ** rng.uniform((-5, -1, -1), (0, 1, 1))
        yield N, 0.0 if i % 4 == 0 else float(zeta_T), float(M), float(V)


def runs(N, zeta_T, M, V, accuracy, law, method, one=DOUBLE):
    """One attempt by either scheme, whatever the rule says; one: of the explicit one's precision."""
    chain, speed = make_chain(N, zeta_T, M, bistable=law == "bistable"), V * V0
    if method == EXPLICIT:
        rule = rules.explicit_rule(chain, accuracy)
        return chain, explicit.run_explicit(chain, speed, rule, rule, 10**8, 0.0, False, new_watch(()), one)
    rule = rules.implicit_rule(chain, speed, accuracy)
    return chain, implicit.run_implicit(chain, speed, rule, rule, 10**8, new_watch(()))


# Accuracy


@pytest.mark.parametrize("accuracy", [1e-3, 1e-4, 1e-6])
def test_well_conditioned_reference_cases_are_within_the_accuracy(reference, accuracy):
    """Measured: 90 % within 0.8 of the accuracy, all within 1.3, median 0.06."""
    cases = [case for case in reference if case["condition"] < 100]
    errors = []
    for law, case in itertools.product(LAWS, cases):
        out, ke = peak(case["N"], case["zeta_T"], case["M_over_M0"], case["V_over_V0"], accuracy, law)
        assert (out.status, out.retries) == (DONE, 0)
        errors.append(abs(ke / case[f"ke_{law}"] - 1) / accuracy)
    assert np.quantile(errors, 0.9) < 1
    assert max(errors) < 3


FIXED = [(2, 0.0, 1.0, 1.0), (3, 0.0, 2.0, 0.5), (5, 1e-3, 0.5, 3.0), (2, 1.0, 1.0, 1.0), (17, 1.0, 0.3, 5.0)]


@pytest.mark.parametrize("law", LAWS)
def test_random_and_stiff_tasks_agree_with_dormand_prince(law):
    """In units of the accuracy, or of what a change of the impact speed by it changes, if that is more."""
    accuracy, step = 1e-5, 1e-6
    for N, zeta_T, M, V in [*FIXED, *random_tasks(8, 7, 40)]:
        chain, speed = make_chain(N, zeta_T, M, bistable=law == "bistable"), V * V0
        wanted, near = (
            rk45.integrate(chain, x, 1e-10, 1e-13, 10**8, 2.25 * N, new_watch(())) for x in (speed, speed * (1 + step))
        )
        condition = abs((near.speed / wanted.speed) ** 2 / (1 + step) ** 2 - 1) / step
        out, _ = peak(N, zeta_T, M, V, accuracy, law)
        assert out.status == DONE
        assert abs((out.speed / wanted.speed) ** 2 - 1) < 5 * accuracy * max(1, condition), (N, zeta_T, M, V)


PUSHED_AGAIN = [  # light impactors, whose contact opens and closes many times while the wave runs
    (12, 0.07730175104600405, 0.8628670772895674, 6.1079506067258755),
    (28, 0.05068726706029339, 0.31135364995575474, 2.81819562468958),
    (27, 0.06089007921476255, 0.31930828266842, 8.923135200503838),
    (102, 0.12182776629739563, 0.1008915506928504, 1.2779094437508753),
    (13, 0.3704081434302006, 0.9568728398283358, 0.9141175212017161),
]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_implicit_steps_do_not_pass_over_what_the_contact_does(law, accuracy):
    """Passing over its openings and closings they were off by up to 25 accuracies, at 1e-6 by 200."""
    for N, zeta_T, M, V in PUSHED_AGAIN:
        chain, wanted = make_chain(N, zeta_T, M, bistable=law == "bistable"), 1e-10
        true = rk45.integrate(chain, V * V0, wanted, 1e-3 * wanted * min(1.0, V), 10**8, 2.25 * N, new_watch(()))
        _, found = runs(N, zeta_T, M, V, accuracy, law, IMPLICIT)
        assert found.status == true.status == DONE
        assert abs((found.speed / true.speed) ** 2 - 1) < 4 * accuracy, (N, zeta_T, M, V)


def test_the_two_schemes_agree_where_both_are_sound():
    task = (40, 0.0125, 1.0, 2.0)
    results = [runs(*task, 1e-5, "bistable", method)[1] for method in (EXPLICIT, IMPLICIT)]
    assert results[0].speed == pytest.approx(results[1].speed, rel=3e-5)
    assert results[0].t == pytest.approx(results[1].t, abs=1e-2)


# Order


def exact(chain, v, t):
    """Velocities of the linear chain without contact, from rest strains and velocities v, at t."""
    n = chain.N
    stretch = np.eye(n, k=1) - np.eye(n)  # de/dt = stretch v; the wall is at rest
    pull = -stretch.T
    system = np.block([[np.zeros((n, n)), stretch], [pull, 2 * chain.zeta * pull @ stretch]])
    return (expm(system * t) @ np.concatenate([np.zeros(n), v]))[n:]


def explicit_march(chain, v, t, steps):
    s = explicit.new_state(chain.N, 0.0, DOUBLE)
    s.v[1 : chain.N + 1] = v
    for _ in range(steps):
        explicit.step(chain, s, chain.N, t / steps)
    return s.v[1 : chain.N + 1]


def numbered_lanes(N):
    f = lanes.new_lanes(N)
    lanes.number(f, N)
    return f


def places(N, rows):
    """Where the sites lie: `rows` consecutive ones in each lane."""
    return [lanes.LANES * (i % rows + 1) + i // rows for i in range(N)]


def implicit_march(chain, v, t, steps):
    N, h, s, f = chain.N, t / steps, damped.new_state(chain.N), numbered_lanes(chain.N)
    sites = places(N, lanes.rows_of(N))
    s.v[sites] = v
    reach, pending = lanes.factor(N, f, h * chain.zeta), 0.0
    for _ in range(steps):
        solve(chain, s, f, reach, pending + h / 2, h)
        pending = h / 2
    return s.v[sites]


def solve(chain, s, f, reach, drift, h, impulse=0.0):
    """One step without contact; the velocity of site 1 before the impulse on it."""
    rows = lanes.rows_of(chain.N)
    damped.push_right(chain, *s, f.carry, f.weight, f.from_left, rows, reach, drift, h, h * chain.zeta)
    first = lanes.substitute_left(s.v, f.carry, f.pivot, f.weight, f.from_left, f.from_right, rows, reach)
    lanes.add_up(s.v, f.carry, f.from_right, f.column, impulse, rows, reach)
    return first


def observed_orders(march, chain, t, counts):
    v = np.random.default_rng(3).normal(size=chain.N)
    errors = [np.abs(march(chain, v, t, n) - exact(chain, v, t)).max() for n in counts]
    return np.log2(np.array(errors[:-1]) / errors[1:])


@pytest.mark.parametrize("N", [5, 8, 21])
def test_the_undamped_explicit_step_converges_with_order_4(N):
    chain = Chain(N, 0.0, LINEAR, ThreeHalves(0.0), 1.0, 2.25 * N, (N + 1) // 2)
    assert observed_orders(explicit_march, chain, 4.0, (8, 16, 32)) == pytest.approx([4, 4], abs=0.3)


@pytest.mark.parametrize("N", [5, 8, 21])
def test_light_damping_costs_the_explicit_step_at_most_one_order(N):
    chain = Chain(N, 0.05, LINEAR, ThreeHalves(0.0), 1.0, 2.25 * N, (N + 1) // 2)
    assert np.all(observed_orders(explicit_march, chain, 4.0, (8, 16, 32)) > 2.8)


@pytest.mark.parametrize("N", [5, 16, 40])
def test_the_crank_nicolson_step_converges_with_order_2(N):
    chain = Chain(N, 1.0, LINEAR, ThreeHalves(0.0), 1.0, 2.25 * N, (N + 1) // 2)
    assert observed_orders(implicit_march, chain, 4.0, (40, 80, 160)) == pytest.approx([2, 2], abs=0.15)


# Parts


def test_the_splitting_is_consistent_and_symmetric_and_its_damper_correction_is_an_exponential_to_third_order():
    a, b = coefficients.DRIFTS, coefficients.KICKS
    assert sum(a) == pytest.approx(1, abs=1e-15)
    assert sum(b) == pytest.approx(1, abs=1e-15)
    assert a == a[::-1]
    assert b == b[::-1]
    x, total = 1e-2, 1.0
    for stage, weight in enumerate(b):
        correction = (
            coefficients.SECOND * x**2 + coefficients.THIRD * x**3 if stage in coefficients.MIDDLE_KICKS else 0.0
        )
        total *= 1 + weight * x + correction
    assert abs(total - np.exp(x)) < 0.1 * x**4


@pytest.mark.parametrize("N", [2, 5, 15, 16, 17, 100, 333, 1000])
@pytest.mark.parametrize("q", [0.0, 1e-3, 0.2, 1.0, 30.0, 1e4])
def test_the_solve_in_lanes_equals_a_dense_solve(N, q):
    """Of (1 + q S) v' = (1 - q S) v: steps so short that springs do nothing, dampers so strong that they still do."""
    h, rows = 1e-30, lanes.rows_of(N)
    matrix = np.eye(N) + q * (2 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1))
    matrix[0, 0] -= q
    rng = np.random.default_rng(N)
    right, impulse, f, s = rng.normal(size=N), 0.7, numbered_lanes(N), damped.new_state(N)
    sites = places(N, rows)
    s.v[sites] = right
    chain = make_chain(N, 0.0, 1.0, bistable=False)._replace(zeta=q / h)
    first = solve(chain, s, f, lanes.factor(N, f, q), 0.0, h, impulse)
    without = np.linalg.solve(matrix, (2 * np.eye(N) - matrix) @ right)
    assert first == pytest.approx(without[0], rel=1e-9, abs=1e-12 * np.abs(without).max())
    wanted = without + impulse * np.linalg.solve(matrix, np.eye(N)[0])
    assert np.abs(s.v[sites] - wanted).max() < 1e-11 * np.abs(wanted).max()
    beyond = np.setdiff1d(np.arange(lanes.LANES, lanes.LANES * (rows + 1)), sites)
    assert not s.v[beyond].any()


def test_the_implicit_contact_gives_back_the_energy_that_it_took():
    rng = np.random.default_rng(5)
    for _ in range(500):
        K, softness = 10 ** rng.uniform((0, -8), (6, -2))
        contact = ThreeHalves(K)
        d0, d_free = rng.normal(size=2) * 10 ** rng.uniform(-8, -1, size=2)
        d1, push = contact.impulse(d0, d_free, softness)
        assert d1 == pytest.approx(d_free - softness * push, rel=1e-9, abs=1e-9 * max(abs(d0), abs(d_free)))
        gained = contact.energy_at(d1) - contact.energy_at(d0)
        resolved = 1e-9 * max(abs(d0), abs(d_free)) / softness  # of the push: it is a difference of overlaps
        assert push * (d1 - d0) == pytest.approx(gained, rel=1e-9, abs=resolved * abs(d1 - d0))
        assert push >= -resolved


@pytest.mark.parametrize("shift", [0.3, 0.5, 0.9])
def test_a_crest_within_a_step_is_found_where_it_is(shift):
    def v(s):
        return -2 + (s - shift) ** 2 * (1 + 0.2 * s)

    def a(s):
        return 2 * (s - shift) * (1 + 0.2 * s) + 0.2 * (s - shift) ** 2

    def jerk(s):
        return 2 * (1 + 0.2 * s) + 0.8 * (s - shift)

    h = 0.25  # the step; a and jerk are derivatives by time
    for best, where in (
        cubic_crest(h, v(0), v(1), a(0) / h, a(1) / h),
        quintic_crest(h, v(0), v(1), a(0) / h, a(1) / h, jerk(0) / h**2, jerk(1) / h**2),
    ):
        assert best == pytest.approx(2, rel=1e-12)
        assert where == pytest.approx(shift, abs=1e-6)


@pytest.mark.parametrize(("one", "rel"), [(DOUBLE, 1e-13), (SINGLE, 1e-5)])
def test_acceleration_of_the_packed_sweep_is_that_of_the_model(one, rel):
    chain = make_chain(21, 1e-3, 1.0, bistable=True)
    rng = np.random.default_rng(8)
    s = explicit.new_state(21, 0.0, one)
    s.e[1:22], s.v[1:22] = rng.normal(size=(2, 21)) * 0.2
    u = -np.cumsum(s.e[21:0:-1])[::-1]
    x, damper = s.e[1:22], 2 * chain.zeta * np.diff(s.v[1:23])
    tension = x + chain.spring.excess(x) + damper
    sweeps.accelerate(chain, s.e, s.v, s.a, 21, 0.0, s.end)
    np.testing.assert_allclose(s.a[1:22], np.diff(tension, prepend=0.0), rtol=rel, atol=rel / 10)
    s.v[0], s.e[0] = 0.3, -0.01
    assert explicit.energy(chain, s) == pytest.approx(energy(chain, u, s.v[1:22], u[0] + 0.01, 0.3), rel=10 * rel)


# Promises


@pytest.mark.parametrize("law", LAWS)
def test_energy_at_the_end_is_not_above_that_at_the_start(law):
    """Damped runs lose energy; undamped ones keep it to their accuracy."""
    for N, zeta_T, M, V in random_tasks(60, 11, 120):
        method = EXPLICIT if N * zeta_T < 0.4 else IMPLICIT
        chain, run = runs(N, zeta_T, M, V, 1e-4, law, method)
        start = chain.impactor_mass * (V * V0) ** 2 / 2
        assert run.status == DONE
        assert 0 < run.energy < start * (1 + (1e-3 if zeta_T == 0 else 1e-4)), (N, zeta_T, M, V)


@pytest.mark.parametrize("law", LAWS)
def test_the_corners_of_the_box_end_done(law):
    for N, zeta_T, M, V in itertools.product((2, 1000), (0.0, 1e-6, 10.0), (0.01, 100.0), (0.01, 20.0)):
        out, ke = peak(N, zeta_T, M, V, 1e-3, law)
        assert (out.status, out.retries) == (DONE, 0), (N, zeta_T, M, V)
        assert 0 < ke <= 1
        assert 0 <= out.t <= 2.25 * N


def test_the_bits_of_a_task_do_not_depend_on_what_ran_before_it():
    tasks = list(random_tasks(30, 2, 100))
    alone = [tuple(peak(*task)[0]) for task in tasks]
    assert [tuple(peak(*task)[0]) for task in reversed(tasks)] == alone[::-1]


@pytest.mark.parametrize("task", [(200, 1e-4, 1.0, 1.0), (60, 0.0, 0.3, 8.0), (333, 1e-3, 2.0, 0.2)])
def test_sites_ahead_of_the_wave_are_not_integrated_and_not_missed(task):
    chain, V = make_chain(*task[:3], bistable=True), task[3] * V0
    rule = rules.explicit_rule(chain, 1e-3)
    window, whole = (
        explicit.run_explicit(chain, V, rule, rule, 10**8, 0.0, x, new_watch(()), DOUBLE) for x in (False, True)
    )
    assert window.speed == pytest.approx(whole.speed, rel=1e-12)
    assert window.t == pytest.approx(whole.t, rel=1e-12)
    assert whole.evaluations == pytest.approx(whole.site_evaluations / task[0], abs=1)
    assert window.site_evaluations < 0.96 * whole.site_evaluations


@pytest.mark.parametrize(
    "task", [(300, 4e-3, 1.0, 1.0), (1000, 4e-4, 0.553, 10.0), (400, 0.1, 0.3, 3.0), (90, 3.0, 1, 1)]
)
def test_sites_ahead_of_the_wave_are_not_solved_for_and_not_missed(task):
    """Nor those that strong dampers move at once: a step of the last chain reaches all its sites."""
    N, chain, V = task[0], make_chain(*task[:3], bistable=True), task[3] * V0
    rule, found = rules.implicit_rule(chain, V, 1e-3), []
    for n in (min(N, implicit.FIRST_SITES), N):
        s, watch = damped.new_state(N), new_watch(())
        start = implicit.Motion(0.0, 0.0, 0.0, V, 0.0, 0.0, 1.0, 0.0, -np.inf, 0.0, 0.0, n, 0, 0, DONE)
        room, limit = (lanes.new_lanes(N), lanes.new_lanes(1), np.zeros(3)), rules.bounds(chain, V)
        lanes.number(room[0], n)
        m = implicit.march(chain, V, s, *room, start, rule, 1.2 * N, np.inf, 10**8, limit, watch)
        assert m.n == N
        found.append((m, s.v, watch.crests))
    (window, v, crests), (whole, all_v, all_crests) = found
    assert window.best == pytest.approx(whole.best, rel=1e-11)
    assert np.abs(v - all_v).max() < 1e-9 * V
    assert np.abs(crests - all_crests).max() < 1e-9 * V
    assert window.sites < 0.9 * whole.sites or chain.zeta > 10.0


@pytest.mark.parametrize("zeta_T", [1e-3, 0.1])
def test_a_spent_step_budget_is_a_status_not_a_hang(zeta_T):
    out, _ = peak(30, zeta_T, 1.0, 1.0, max_steps=100)
    assert out.status == STEP_BUDGET
    assert 100 <= out.steps < 300  # a step that has begun ends, with its substeps
    enough, _ = peak(30, zeta_T, 1.0, 1.0)
    assert peak(30, zeta_T, 1.0, 1.0, max_steps=enough.steps)[0] == enough


@pytest.mark.parametrize("zeta_T", [1e-3, 0.1])
def test_a_state_that_is_not_finite_is_retried_and_then_a_status(zeta_T):
    out, ke = peak(30, zeta_T, 1.0, 1.0, K=np.nan)
    assert (out.status, out.retries) == (NOT_FINITE, 3)
    assert np.isnan(ke)
    assert np.isnan(out.t)


def test_a_run_that_blows_up_at_coarse_steps_is_done_again_with_finer_ones():
    # Found at random: which task blows up depends on every digit of the steps, so there are four.
    tasks = [(3, 0.0, 3.80185, 6.86103), (38, 0.0, 0.560306, 8.68485)]
    tasks += [(4, 6.09262e-05, 7.47613, 2.02235), (24, 0.0, 0.285935, 8.58446)]
    coarse, fine = ([peak(*task, accuracy=accuracy) for task in tasks] for accuracy in (1.0, 1e-6))
    assert {outcome.status for outcome, _ in coarse} == {DONE}
    assert any(outcome.retries for outcome, _ in coarse)
    assert [ke for _, ke in coarse] == pytest.approx([ke for _, ke in fine], rel=0.05)


@pytest.mark.parametrize("change", [{}, {"max_steps": 10}, {"K": np.nan}, {"zeta_T": 0.1}])
def test_subnormals_are_restored_however_a_run_ends(change):
    task = {"N": 20, "zeta_T": 1e-3, "M": 1.0, "V": 1.0} | change
    peak(**task)
    assert sys.float_info.min / 2 > 0


def test_the_work_follows_the_accuracy():
    """Order 4 and 2: a hundredth of the error costs 100^(1/4) and 100^(1/2) times as much, or little more."""
    for zeta_T, growth in ((1e-4, 100**0.4), (0.1, 100**0.5)):
        work = [peak(100, zeta_T, 1.0, 1.0, accuracy)[0].evaluations for accuracy in (1e-3, 1e-5, 1e-7)]
        assert work[0] < 16 * 2.25 * 100
        assert work[0] < work[1] < 1.3 * growth * work[0]
        assert work[1] < work[2] < 1.6 * growth * work[1]


@pytest.mark.parametrize("zeta_T", [1e-3, 0.01, 0.02, 0.1, 10.0])
@pytest.mark.parametrize("accuracy", [1e-1, 1e-3, 1e-6])
def test_where_dampers_broaden_the_fronts_steps_are_longer_but_never_beyond_what_the_springs_bear(zeta_T, accuracy):
    """Their leapfrog is stable below 2 over the largest frequency, 2 sqrt(f'), whatever the dampers do."""
    chain, narrow = make_chain(200, zeta_T, 1.0, bistable=True), make_chain(200, 1e-3, 1.0, bistable=True)
    long, close = (rules.implicit_rule(x, V0, accuracy) for x in (chain, narrow))
    wider = min(rules.BROADENING_MAX, max(1.0, chain.zeta))
    assert long.theta < 2
    assert 2 * long.h_max < 2
    assert long.theta == pytest.approx(min(1.9, wider * close.theta))
    assert long.h_max == pytest.approx(min(0.9, wider * close.h_max))


def test_strong_damping_costs_no_more_than_weak_damping():
    work = {zeta_T: peak(200, zeta_T, 1.0, 1.0)[0].evaluations for zeta_T in (1e-4, 1e-2, 1.0, 10.0)}
    assert max(work[zeta_T] for zeta_T in (1e-2, 1.0, 10.0)) < work[1e-4]


# Compiled code

SMALL = [(3, 1e-3, 1.0, 1.0), (18, 1e-3, 1.0, 0.3), (5, 0.0, 1.0, 1.0), (3, 0.5, 1.0, 1.0), (20, 0.5, 1.0, 1.0)]

PLAIN = """
import json
from tests.test_kernel_splitting import SMALL, runs_of_both_precisions
for task in SMALL:
    print(json.dumps([[float(x) for x in run] for run in runs_of_both_precisions(*task)]))
"""


def runs_of_both_precisions(N, zeta_T, M, V):
    """By the scheme that serves it, in double precision and, where that is the explicit one, in single."""
    if N * zeta_T >= SWITCH:
        return [runs(N, zeta_T, M, V, 0.1, "bistable", IMPLICIT)[1]]
    return [runs(N, zeta_T, M, V, 0.1, "bistable", EXPLICIT, one)[1] for one in (DOUBLE, SINGLE)]


def test_compiled_code_does_what_plain_python_does():
    """In double precision to its rounding, which late, chaotic motion lets grow in the energy that is left.

    In single precision NumPy rounds otherwise, as its results are double where one operand is.
    """
    path = [*sys.path, str(Path(__file__).parent.parent)]  # the installed packages before the checkout's tests
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(path)}
    result = subprocess.run(
        [sys.executable, "-P", "-W", "error", "-c", PLAIN], env=environment, capture_output=True, text=True, timeout=120
    )
    assert result.returncode == 0, result.stderr
    for task, line in zip(SMALL, result.stdout.splitlines(), strict=True):
        (plain, *plain_single), (run, *single) = json.loads(line), runs_of_both_precisions(*task)
        assert [plain[0], *plain[3:6], plain[7]] == [run.status, run.steps, run.evaluations, *run[5:6], run.retries]
        assert plain[1:3] == pytest.approx([run.speed, run.t], rel=1e-12)
        assert plain[6] == pytest.approx(run.energy, rel=1e-8)
        for one, other in zip(plain_single, single, strict=True):
            assert one[1:3] == pytest.approx([other.speed, other.t], rel=2e-5)


@pytest.mark.parametrize("law", LAWS)
def test_single_precision_moves_a_peak_far_less_than_the_steps_do(law):
    """Measured: the largest relative difference of energies is 5e-6, a twentieth of the accuracy."""
    for N, zeta_T, M, V in random_tasks(60, 12, 120):
        if N * zeta_T >= SWITCH:
            continue
        (chain, double), (_, single) = (runs(N, zeta_T, M, V, 1e-4, law, EXPLICIT, one) for one in (DOUBLE, SINGLE))
        rule = rules.explicit_rule(chain, 1e-4)
        near = explicit.run_explicit(chain, V * V0, rule, rule, 10**8, 1e-6, False, new_watch(()), DOUBLE)
        sensitive = abs((near.speed / double.speed) ** 2 - 1) / 1e-6 > 30
        assert sensitive or abs((single.speed / double.speed) ** 2 - 1) < 2e-5, (N, zeta_T, M, V)


@pytest.mark.parametrize("law", [PowerLaw(1.5, 100.0), PowerLaw(3.0, 100.0), PowerLaw(1.5, 1.0), Toda(1e-3)])
def test_single_precision_tells_the_small_bend_of_a_spring_that_is_hardly_strained(law):
    """Strains are 1e-5 of the precompression: 1 - e/d in single precision would be off by a hundredth of e/d."""
    chain, V = make_chain(40, 1e-4, 1.0, bistable=True)._replace(spring=law), 0.01 * V0
    rule = rules.explicit_rule(chain, 1e-3)
    double, single = (
        explicit.run_explicit(chain, V, rule, rule, 10**8, 0.0, False, new_watch(()), one) for one in (DOUBLE, SINGLE)
    )
    assert (single.speed / double.speed) ** 2 == pytest.approx(1.0, abs=2e-5)


@pytest.mark.parametrize(("spring", "kept"), [(PowerLaw(6.0, 0.0), DOUBLE), (PowerLaw(1.5, 0.01), SINGLE)])
def test_grains_that_only_touch_are_kept_in_double_precision_and_pressed_ones_need_not_be(spring, kept):
    """The tension of the former is far below their strain, from which single precision could not tell it."""
    chain, V = make_chain(20, 0.0, 1.0, bistable=True)._replace(spring=spring), V0
    rule, later = rules.explicit_rule(chain, 1e-3), rules.explicit_rule(chain, AFTERWARDS)
    run = explicit.run_explicit(chain, V, rule, later, 10**8, 0.0, False, new_watch(()), kept)
    assert run_by(EXPLICIT, chain, V, 0.0, 1e-3, 10**8, new_watch(())) == run


@given(st.floats(1.0, 3.0), st.floats(0.03, 0.4))
def test_a_collision_that_whole_substeps_fill_ends_with_the_speed_that_it_began_with(p, wanted):
    contact, mass = AnyPower(1.0, p), 1.0
    chain = make_chain(10, 0.0, 1.0, bistable=True)._replace(contact=contact, impactor_mass=1e12)  # the site's is 1
    whole = rules.collision(chain)
    eta = rules.whole_substeps(whole, wanted)
    assert eta == pytest.approx(wanted, rel=0.51 * wanted / whole * 1.3)
    dt, d, speed = eta * contact.period(mass, 0.5), 0.0, 1.0
    while d > 0.0 or speed > 0.0:
        d += 0.5 * dt * speed
        speed -= dt * contact.push(d) / mass
        d += 0.5 * dt * speed
    assert speed == pytest.approx(-1.0, abs=0.02 * eta**2.5)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="reads x86 assembly")
def test_the_hot_sweeps_are_packed():
    s, f, chain = explicit.new_state(64, 0.1, DOUBLE), numbered_lanes(64), make_chain(64, 1e-3, 1.0, bistable=True)
    near, rule, border = zone.new_zone(64), rules.explicit_rule(chain, 1e-3), zone.border_between(0.1, *[0.0] * 4)
    calls = {
        sweeps.kick: (chain, s.e, s.v, 64, 0.1, 0.1, s.end),
        sweeps.accelerate: (chain, s.e, s.v, s.a, 64, 0.1, s.end),
        sweeps.spread: (s.v, s.a, 64, 0.1, 0.1, 0.1, s.end),
        zone.resolve: (chain, near.e, near.v, near.mask, rule, border, 0.1, 0, 0.0, ()),
        lanes.add_up: (s.v, f.carry, f.from_right, f.column, 0.1, lanes.rows_of(64), lanes.rows_of(64)),
    }
    for function, arguments in calls.items():
        # A function from numba's cache has no assembly.
        copy = numba.njit(error_model="numpy", fastmath=FASTMATH)(function.py_func)
        copy(*arguments)
        (assembly,) = copy.inspect_asm().values()
        assert len(re.findall(r"\bv?(?:fn?m\w+|mul|add|sub)pd\b", assembly)) >= 4, function


@pytest.mark.parametrize("site", [1, 2, 7, 39, 40])
@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_a_crest_is_seen_at_the_struck_end_and_at_the_wall_as_in_the_middle(site, accuracy):
    """Site 1 was looked at between its own substeps only, the last one as if the wall moved: off by 0.30 and 0.036."""
    for law, zeta_T, M, V in itertools.product(LAWS, (1e-4, 5e-3), (0.3, 3.0), (0.1, 0.3)):
        chain = make_chain(40, zeta_T, M, bistable=law == "bistable")._replace(site=site, t_end=60.0)
        true = rk45.integrate(chain, V * V0, 1e-9, 1e-13, 10**8, chain.t_end, new_watch(())).speed
        rule = rules.explicit_rule(chain, accuracy)
        run = explicit.run_explicit(chain, V * V0, rule, rule, 10**8, 0.0, False, new_watch(()), DOUBLE)
        assert run.speed == pytest.approx(true, rel=2.5 * accuracy), (law, zeta_T, M, V)


@pytest.mark.parametrize("N", [16, 31, 32])
@pytest.mark.parametrize("law", LAWS)
def test_implicit_steps_see_the_last_site_before_the_wall_however_the_chain_fills_its_lanes(N, law):
    """Where it does, the wall was taken for the second site: a crest that never was had 0.78 of the peak."""
    for zeta, V in ((1.6, 0.3), (10.0, 1.0), (96.0, 1.0)):
        chain = make_chain(N, zeta / N, 0.1, bistable=law == "bistable")._replace(site=N, t_end=2.25 * N)
        ours, theirs = new_watch(()), new_watch(())
        rule = rules.implicit_rule(chain, V * V0, 1e-3)
        implicit.run_implicit(chain, V * V0, rule, rule, 10**8, ours)
        rk45.integrate(chain, V * V0, 1e-8, 1e-12, 10**8, chain.t_end, theirs)
        assert np.abs(ours.crests - theirs.crests).max() < 0.08 * theirs.crests.max(), (zeta, V)


@pytest.mark.parametrize("task", [(11, 1.3, 1.02), (18, 3.59, 9.5), (10, 26.28, 0.27)], ids=str)
def test_the_hardest_contact_brings_no_energy_into_a_chain_that_is_not_damped(task):
    """Each linear chain gained more than 1 % in four tries: links pushed its end into the impactor in one substep."""
    N, M, V = task
    model, how = Model(contact=Hertz(1e12), t_end=5.0), {"accuracy": 0.1, "certify": False}
    fast, slow = (ke_ratio(N, 0.0, M, V, method=method, model=model, **how) for method in ("auto", "rk45"))
    assert (fast.status, fast.method, slow.method) == ("done", "explicit", "rk45")
    assert fast.ke_linear == pytest.approx(slow.ke_linear, rel=0.05)
