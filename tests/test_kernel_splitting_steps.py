"""Order and exactness of the steps of the splitting integrators, and of their parts."""

import platform
import re

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from kernel.jit import FASTMATH
from kernel.laws.any_power import AnyPower
from kernel.laws.hertz import ThreeHalves
from kernel.maxima import cubic_crest, quintic_crest
from kernel.model import Chain, energy, make_chain
from kernel.simd import DOUBLE, SINGLE
from kernel.splitting import (
    coefficients,
    damped,
    explicit,
    lanes,
    rules,
    sweeps,
    zone,
)

from .splitting import LINEAR, numbered_lanes


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
