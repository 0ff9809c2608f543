"""Scenes against what is known exactly: reflection at free and fixed ends, a driven linear chain, a push that parts."""

from functools import partial

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, quad
from scipy.special import jv

import kernel
from kernel.film import new_film
from kernel.filming import filmed
from kernel.method import choose
from kernel.varied import driven_acceleration

pytestmark = pytest.mark.slow
LINEAR = kernel.Bistable(0.0, 0.0)


def velocities(event, N, at, accuracy=1e-8, **model):
    """Of all sites at the times `at` over N."""
    chain = kernel.Model(spring=LINEAR, t_end=max(at), **model)
    seen = kernel.simulate(kernel.Scene(N, 0.0, event, model=chain, observe={"profile": {"at": at}}), accuracy)
    assert seen.status == "done"
    return seen["profile"]["v"]


@pytest.mark.parametrize("wall", ["free", "fixed"])
def test_a_chain_released_at_one_end_moves_as_its_modes(wall):
    N, at = 20, [0.3, 1.0, 2.0]
    v = np.eye(N)[0]
    stiffness = 2 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1)
    stiffness[0, 0] = 1.0
    if wall == "free":
        stiffness[-1, -1] = 1.0
    squares, modes = np.linalg.eigh(stiffness)
    found = velocities(kernel.Release(np.zeros(N), v), N, at, wall=wall)
    for k, t in enumerate(at):
        true = modes @ (np.cos(np.sqrt(np.maximum(squares, 0.0)) * t * N) * (modes.T @ v))
        assert np.abs(found[k] - true).max() < 1e-10


@pytest.mark.parametrize(("wall", "side"), [("free", 1.0), ("fixed", -1.0)])
def test_a_long_pulse_comes_back_from_a_free_end_as_it_went_and_upside_down_from_a_wall(wall, side):
    N = 400
    pulse = np.exp(-(((np.arange(N) - 200) / 30.0) ** 2))
    right = kernel.Release(u=np.cumsum(pulse[::-1])[::-1], v=pulse)  # u' = -v: all of it goes to the right
    at_end, back = velocities(right, N, [200.0 / N, 400.0 / N], wall=wall)
    assert np.abs(back[100:300] - side * pulse[100:300]).max() < 0.03
    assert at_end[-1] == pytest.approx(1.0 + side, abs=0.03), "twice the speed at a free end, none at a wall"


HISTORIES = {
    "constant": (0.1, lambda t: 0.1 + 0.0 * t),
    "ramp": (kernel.Ramp(0.1, 0.2), lambda t: 0.1 * np.minimum(t / 12.0, 1.0)),
    "half_sine": (kernel.HalfSine(0.1, 0.25), lambda t: np.where(t < 15.0, 0.1 * np.sin(np.pi * t / 15.0), 0.0)),
    "harmonic": (kernel.Harmonic(0.1, 0.1), lambda t: 0.1 * np.sin(2 * np.pi * t / 6.0)),
    "samples": (
        kernel.Samples([0.0, 0.1, 0.2, 0.3], [0.02, 0.1, -0.05, 0.0]),
        lambda t: np.interp(t, [0.0, 6.0, 12.0, 18.0], [0.02, 0.1, -0.05, 0.0]),
    ),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_a_driven_linear_chain_moves_as_bessels_functions_say(name):
    """A site n links behind one that moves with v(t): its velocity is the convolution of v with 2n J_2n(2t) / t."""
    N, end = 60, 24.0
    history, v = HISTORIES[name]
    strain = {"strain": 0.1 * end / N} if name == "constant" else {}
    (found,) = velocities(kernel.Drive(history, hold=True, **strain), N, [end / N])
    assert found[0] == pytest.approx(float(v(end)), abs=1e-9)
    for n in (1, 5, 20, 24):
        true, _ = quad(
            lambda s: 2 * n * jv(2 * n, 2 * s) / s * float(v(end - s)),  # noqa: B023
            0.0,
            end,
            epsabs=1e-11,
            limit=400,
            points=[6.0, 9.0, 12.0, 18.0],
        )
        assert found[n] == pytest.approx(true, abs=1e-8), n


SAMPLED = np.linspace(0.0, 24.0, 300)
NOISE = np.random.default_rng(3).normal(0.0, 0.05, 300)
NOISY = {"noise": (kernel.Samples(SAMPLED / 60, NOISE), partial(np.interp, xp=SAMPLED, fp=NOISE))}


@pytest.mark.parametrize("hold", [True, False])
@pytest.mark.parametrize("name", [*HISTORIES, "noise"])
def test_a_driver_and_what_it_holds_are_where_they_are_told_to_be_however_coarse_the_steps(name, hold):
    history, v = (HISTORIES | NOISY)[name]
    strain = {"strain": 0.1 * 0.4} if name == "constant" else {}
    scene = kernel.Scene(60, 1e-3, kernel.Drive(history, hold=hold, **strain), observe={"profile": {"at": [0.4]}})
    film = new_film(60 * np.linspace(0.05, 0.4, 40), 60, displacements=True)
    filmed(scene, choose("rk45", 1e-2), {}).fill(film)
    u, moved = (film.u[:, 0], film.v[:, 0]) if hold else film.impactor.T
    grid = np.union1d(np.linspace(0.0, 24.0, 200_001), SAMPLED)
    assert moved == pytest.approx(v(film.times), abs=1e-12)
    assert u == pytest.approx(np.interp(film.times, grid, cumulative_trapezoid(v(grid), grid, initial=0.0)), abs=1e-8)


@pytest.mark.parametrize("name", [*HISTORIES, "noise"])
def test_a_drivers_acceleration_is_the_slope_of_its_velocity(name):
    history, v = (HISTORIES | NOISY)[name]
    event = kernel.Drive(history, hold=True, strain=0.04 if name == "constant" else None)
    motion = kernel.Scene(60, 0.0, event, observe="quasi_static").chain.varied.motion
    for t in np.linspace(0.25, 23.75, 48):
        slope = (v(t + 1e-6) - v(t - 1e-6)) / 2e-6
        assert driven_acceleration(motion, t, t) == pytest.approx(slope, rel=1e-6, abs=1e-9), t


@pytest.mark.parametrize("accuracy", [1e-2, 1e-6])
@pytest.mark.parametrize("hold", [True, False])
def test_a_driver_that_jumps_costs_no_more_than_one_that_does_not(hold, accuracy):
    """Steps end where pieces of its motion do. Before, all steps of a run were as short as its shortest piece."""

    def seen(history):
        scene = kernel.Scene(9, 1e-3, kernel.Drive(history, hold=hold), observe={"profile": {"at": [0.5, 1.0]}})
        return kernel.simulate(scene, accuracy)

    steady = seen(kernel.Samples([0.0, 1.0], [0.1, 0.1]))
    for rise in (1e-4, 1e-8, 1e-12, 1e-15):
        jumps = seen(kernel.Ramp(0.1, rise))
        assert jumps.steps < 1.2 * steady.steps + 40
        assert jumps["profile"]["v"] == pytest.approx(steady["profile"]["v"], abs=max(accuracy, 10 * rise) * 0.1)
    back = [seen(kernel.Samples([0.0, 0.3, 0.3 + width, 1.0], [0.1, 0.1, -0.2, 0.1])) for width in (1e-6, 1e-12)]
    assert max(one.steps for one in back) < 1.2 * steady.steps + 40
    assert back[1]["profile"]["v"] == pytest.approx(back[0]["profile"]["v"], abs=max(accuracy, 1e-4) * 0.1)


def test_a_first_site_that_is_held_stays_where_it_was_released():
    event = kernel.Release(u=[0.02, *[0.0] * 7], v=[0.0] * 8, hold=True)
    seen = kernel.simulate(kernel.Scene(8, 1e-3, event, observe={"profile": {"at": [0.3, 2.25]}}))["profile"]
    assert (seen["u"][:, 0] == 0.02).all()
    assert (seen["v"][:, 0] == 0.0).all()
    assert np.abs(seen["u"][-1, 1:]).max() > 1e-3


def test_a_driver_that_does_not_hold_the_chain_parts_from_it():
    N, pulse = 60, kernel.HalfSine(0.1, 0.1)
    pushed, held = (
        kernel.simulate(kernel.Scene(N, 0.0, kernel.Drive(pulse, hold=hold), observe={"profile": {"at": [0.5]}}), 1e-6)[
            "profile"
        ]["v"][0]
        for hold in (False, True)
    )
    assert held[0] == pytest.approx(0.0, abs=1e-8), "the driver stands, and with it what it holds"
    assert abs(pushed[0]) > 1e-4, "a first site that nothing holds still moves"


def test_a_constant_push_through_a_history_is_the_constant_push():
    """Two routes: the impactor of infinite mass, and a driver whose velocity is told."""
    N, at = 20, [0.2, 0.5]
    told = kernel.Drive(kernel.Samples([0.0, 1.0], [0.05, 0.05]))
    ways = (kernel.Drive(0.05, strain=0.05 * 2.25), told)
    one, other = (
        kernel.simulate(kernel.Scene(N, 1e-3, way, observe={"profile": {"at": at}}), 1e-8)["profile"]["v"]
        for way in ways
    )
    assert np.abs(one - other).max() < 1e-7


@pytest.mark.parametrize("model", [{"mass": kernel.Graded(1.0, 1.0)}, {"wall": "free"}], ids=["listed", "free"])
def test_a_constant_push_moves_a_chain_that_is_not_uniform_too(model):
    chain = kernel.Model(spring=LINEAR, **model)
    seen = kernel.simulate(kernel.Scene(20, 1e-3, kernel.Drive(0.1), model=chain, observe="profile"))
    uniform = kernel.simulate(
        kernel.Scene(20, 1e-3, kernel.Drive(0.1), model=kernel.Model(spring=LINEAR), observe="profile")
    )
    early = seen["profile"]["t"] < 0.9  # before the wave comes to the other end
    assert np.abs(seen["profile"]["v"][early]).max() > 0.1
    assert seen["profile"]["v"][early] == pytest.approx(uniform["profile"]["v"][early], abs=1e-4)


@pytest.mark.parametrize("size", [1.0, 1e-6, 1e-9])
def test_a_linear_chain_answers_in_proportion_however_little_it_is_moved(size):
    events = (kernel.Release(np.zeros(20), size * np.eye(20)[0]), kernel.Drive(kernel.Ramp(0.1 * size, 0.2)))
    for event in events:
        scene = kernel.Scene(20, 0.0, event, law="linear", observe={"profile": {"at": [1.0, 2.0]}})
        moved = kernel.simulate(scene)["profile"]["v"] / size
        tight = kernel.simulate(scene, 1e-7)["profile"]["v"] / size
        assert moved == pytest.approx(tight, abs=1e-3 * np.abs(tight).max())


def test_every_problem_of_a_drive_is_named():
    for make, said in (
        (lambda: kernel.Drive(kernel.Ramp(0.0, -1.0), strain=0.3, hold=1), "speed.speed: .*speed.rise: .*strain: only"),
        (lambda: kernel.Drive(kernel.Samples([0.0, 0.0], [1, 2, 3])), "must be as many, got 2 and 3.*ascend from 0"),
        (lambda: kernel.Drive(kernel.Samples("ab", [0, 0])), "speed.times: must hold 2 to"),
        (lambda: kernel.Drive("fast"), "speed: must be a finite number above 0, got 'fast'"),
        (lambda: kernel.Drive(0.1, hold="yes"), "hold: must be True or False"),
        (lambda: kernel.Drive(1.0, strain=1e308), r"^strain / speed: must be a number from 1e-100 to 1e\+100, got 1e"),
        (lambda: kernel.Drive(5e-324), r"^speed: must be a number from 1e-100 .*strain / speed: .* got inf"),
    ):
        with pytest.raises(ValueError, match=said):
            make()
