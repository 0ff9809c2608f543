"""Order, energy, work and ends of the Dormand-Prince integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from kernel import rk45, stages, state
from kernel.laws.bistable import Bistable
from kernel.laws.hertz import ThreeHalves
from kernel.model import Chain, energy, make_chain
from kernel.status import DONE, NOT_FINITE, STEP_BUDGET
from kernel.task import V0
from kernel.watch import new_watch

from . import twin

SMOOTH = Chain(
    N=6, zeta=0.05, spring=Bistable(0.0, 0.0), contact=ThreeHalves(0.0), impactor_mass=1.0, t_end=13.5, site=3
)  # linear, nothing touches


def exact(chain: Chain, v: np.ndarray, t: float) -> np.ndarray:
    """Velocities of the smooth linear chain at t from rest strains, by the matrix exponential."""
    n = chain.N + 1
    unit = np.eye(n)
    K = np.array([twin.acceleration(chain._replace(zeta=0.0), x, 0 * x) for x in unit]).T
    D = np.array([twin.acceleration(chain, 0 * x, x) for x in unit]).T
    system = np.block([[np.zeros((n, n)), np.eye(n)], [K, D]])
    return (expm(system * t) @ np.concatenate([np.zeros(n), v]))[n:]


def in_motion(chain: Chain, v: np.ndarray) -> state.State:
    """Unstrained, with velocities v (impactor first), its first acceleration taken from the twin."""
    s = state.new_state(chain.N, v[0])
    s.v[: chain.N] = v[1:]
    a = twin.acceleration(chain, 0 * v, v)
    s.k[: chain.N], s.k_impactor[0] = a[1:], a[0]
    return s


def march(steps: int, t: float) -> tuple[float, float]:
    """Error of the solution after fixed steps, and the last step's error estimate."""
    start, h = np.eye(SMOOTH.N + 1)[2], t / steps
    s, estimate, n = in_motion(SMOOTH, start), np.inf, state.padded(SMOOTH.N)
    for i in range(steps):
        estimate = stages.step(SMOOTH.varied, SMOOTH, s, n, 0.0, h, i % 2, 1.0)
    there = steps % 2 * n
    return np.abs(s.v[there : there + SMOOTH.N] - exact(SMOOTH, start, t)[1:]).max(), estimate


def test_the_fixed_step_pair_converges_with_order_5_and_its_error_estimate_with_local_order_5():
    errors, estimates = np.array([march(n, 4.0) for n in (40, 80, 160)]).T
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders == pytest.approx([5, 5], abs=0.35)
    assert np.log2(estimates[:-1] / estimates[1:]) == pytest.approx([5, 5], abs=0.6)


def energies(chain, speed):
    """Status, total energy at the end, energy that the dampers took."""
    settings = rk45.Settings(1e-9, 1e-12, 10**8, 2.25 * chain.N, rk45.REACHED * speed, True)
    march = rk45.start(chain, speed, settings, new_watch(()))
    rk45.advance(chain, march, settings, settings.t_end)
    return march.tally[rk45.STATUS], rk45.energy_at_end(chain, march), march.dissipated[1]


@pytest.mark.parametrize("bistable", [True, False])
@pytest.mark.parametrize("zeta_T", [1e-4, 1e-2])
def test_energy_falls_exactly_by_what_the_dampers_take(bistable, zeta_T):
    chain, speed = make_chain(40, zeta_T, 2.0, bistable=bistable), 2 * V0
    status, left, dissipated = energies(chain, speed)
    TE = chain.impactor_mass * speed**2 / 2
    assert status == DONE
    assert dissipated > 0
    assert abs(TE - left - dissipated) < 1e-6 * TE


def test_without_damping_energy_is_conserved():
    chain, speed = make_chain(30, 0.0, 1.0, bistable=True), 3 * V0
    _, left, dissipated = energies(chain, speed)
    TE = chain.impactor_mass * speed**2 / 2
    assert dissipated == 0
    assert abs(TE - left) < 1e-6 * TE


@pytest.mark.parametrize(("N", "zeta_T", "M", "V"), [(8, 3e-3, 2.0, 1.7), (12, 0.0, 0.5, 4.0), (15, 0.02, 1.0, 0.5)])
@pytest.mark.parametrize("bistable", [True, False])
def test_agrees_with_scipy_dop853_on_the_twin_equations(N, zeta_T, M, V, bistable):
    chain, speed = make_chain(N, zeta_T, M, bistable=bistable), V * V0
    ours = rk45.integrate(chain, speed, 1e-10, 1e-13, 10**8, 2.25 * N, new_watch(()))
    n = N + 1
    start = np.zeros(2 * n)
    start[n] = speed

    def derivative(t, y):
        return np.concatenate([y[n:], twin.acceleration(chain, y[:n], y[n:])])

    theirs = solve_ivp(
        derivative, (0, 2.25 * N), start, "DOP853", rtol=1e-10, atol=1e-13, dense_output=True, max_step=0.5
    )
    t = np.linspace(0, 2.25 * N, 20_000)
    v = np.abs(theirs.sol(t)[n + (N + 1) // 2])
    near = np.linspace(t[max(0, v.argmax() - 1)], t[min(len(t) - 1, v.argmax() + 1)], 2001)
    peak = np.abs(theirs.sol(near)[n + (N + 1) // 2])
    assert ours.speed == pytest.approx(peak.max(), rel=2e-6)
    assert ours.t == pytest.approx(near[peak.argmax()], abs=1e-3)
    assert ours.energy == pytest.approx(twin.energy(chain, theirs.y[:n, -1], theirs.y[n:, -1]), rel=1e-5)


def test_the_work_follows_the_tolerance_and_stays_within_its_budget():
    chain = make_chain(50, 4e-4, 2.0, bistable=True)
    runs = {
        rtol: rk45.integrate(chain, 2 * V0, rtol, 1e-3 * rtol, 10**8, 2.25 * 50, new_watch(()))
        for rtol in (1e-3, 1e-6, 1e-9)
    }
    work = [run.evaluations for run in runs.values()]
    assert work[0] < 60 * 2.25 * 50
    assert work == sorted(work)
    assert 2.5 < work[2] / work[1] < 6  # a fifth-order method: 1000^(1/5) = 4


def test_stiff_damping_costs_steps_as_its_fastest_rate_demands():
    """8 zeta h = 3.31 is the stability limit of the pair on the negative axis."""
    chain = make_chain(20, 1.0, 1.0, bistable=True)
    run = rk45.integrate(chain, V0, 1e-3, 1e-6, 10**8, 45.0, new_watch(()))
    smallest = 2.25 * 20 * 8 * chain.zeta / 3.31
    assert smallest < run.evaluations / 6 < 1.6 * smallest


def test_a_spent_step_budget_is_a_status_not_a_hang():
    run = rk45.integrate(make_chain(20, 0.0, 1.0, bistable=True), V0, 1e-6, 1e-9, 50, 45.0, new_watch(()))
    assert run.status == STEP_BUDGET
    assert run.evaluations == 6 * 50


def test_a_state_that_is_not_finite_is_a_status_not_a_number():
    broken = make_chain(20, 0.0, 1.0, bistable=True)._replace(contact=ThreeHalves(np.nan))
    run = rk45.integrate(broken, V0, 1e-6, 1e-9, 10**6, 45.0, new_watch(()))
    assert run.status == NOT_FINITE


def test_damping_never_lets_the_energy_grow():
    chain = make_chain(25, 5e-3, 1.0, bistable=True)
    s, n = in_motion(chain, 2 * V0 * np.eye(26)[0]), state.padded(25)
    levels = []
    for i in range(4000):
        now = i % 2
        levels.append(energy(chain, s.u[now * n :], s.v[now * n :], *s.impactor[2 * now : 2 * now + 2]))
        stages.step(chain.varied, chain, s, n, 0.0, 2e-3, now, 1.0)
    assert np.all(np.diff(levels) < 1e-9 * levels[0])
    assert levels[-1] < 0.99 * levels[0]


@pytest.mark.parametrize("spring", [Bistable(0.0, 0.0), Bistable()], ids=["linear", "bistable"])
@pytest.mark.parametrize("zeta", [0.0, 0.03])
def test_a_step_reads_nothing_that_the_try_before_left(spring, zeta):
    """A try that blew up leaves accelerations that are not numbers."""
    chain = Chain(6, zeta, spring, ThreeHalves(3e3), impactor_mass=1.7, t_end=13.5, site=3)
    clean, spoilt = (in_motion(chain, 0.05 * np.eye(7)[0]) for _ in range(2))
    spoilt.k[state.padded(6) :] = np.nan
    spoilt.k_impactor[1:] = np.nan
    errors = [stages.step(chain.varied, chain, s, state.padded(6), 0.0, 0.01, 0, 1e-3) for s in (clean, spoilt)]
    assert errors[0] == errors[1]
    for one, other in zip(clean, spoilt, strict=True):
        np.testing.assert_array_equal(one, other)


def test_sites_ahead_of_the_wave_are_not_integrated_and_not_missed():
    chain = make_chain(200, 1e-3, 1.0, bistable=True)  # well-conditioned: at 1e-4 rounding alone moves the peak by 1e-3
    window, whole = (  # any noise, however small, moves all sites at once
        rk45.integrate(chain, V0, 1e-8, 1e-11, 10**8, 450.0, new_watch(()), noise) for noise in (0.0, 1e-100)
    )
    assert window.speed == pytest.approx(whole.speed, rel=1e-11)
    assert whole.site_evaluations == 200 * whole.evaluations
    assert window.site_evaluations < 0.9 * whole.site_evaluations


def test_a_run_in_pieces_takes_the_same_steps_as_a_run_at_once():
    chain, t_end = make_chain(20, 1e-3, 1.0, bistable=True), 45.0
    settings = rk45.Settings(1e-6, 1e-9, 10**6, t_end, 1e-16, False)
    once, pieces = (rk45.start(chain, V0, settings, new_watch(())) for _ in range(2))
    rk45.advance(chain, once, settings, t_end)
    for t in np.linspace(0, t_end, 100):
        rk45.advance(chain, pieces, settings, t)
    assert pieces.clock.tobytes() == once.clock.tobytes()
    assert pieces.s.u.tobytes() == once.s.u.tobytes()


def test_the_state_within_a_step_is_the_continuous_extension():
    chain = make_chain(10, 1e-2, 1.0, bistable=True)
    settings = rk45.Settings(1e-9, 1e-12, 10**6, 22.5, 1e-16, False)
    run, u, v, quartic = rk45.start(chain, V0, settings, new_watch(())), np.zeros(10), np.zeros(10), np.zeros(9)
    rk45.advance(chain, run, settings, 7.0)
    h = run.clock[rk45.T_TO] - run.clock[rk45.T_FROM]
    now = run.tally[rk45.NOW]
    rk45.velocity_quartic(quartic, run.s, now, h, 4)
    for theta in (0.0, 0.3, 1.0):
        impactor = rk45.state_within(run.s, now, h, theta, u, v)
        assert v[3] == pytest.approx(np.polynomial.polynomial.polyval(theta, quartic[:5]), rel=1e-13)
    u_end, v_end, impactor_end = rk45.end_of_step(run)
    np.testing.assert_allclose(u, u_end[:10], rtol=0, atol=1e-14)
    np.testing.assert_allclose(v, v_end[:10], rtol=0, atol=1e-14)
    np.testing.assert_allclose(impactor, impactor_end, rtol=0, atol=1e-14)
