"""Chains that are not uniform: what they mean, that they are integrated rightly, and that they cost others nothing."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kernel
from kernel import rk45
from kernel.along import KINDS, values_along
from kernel.lattice import model_of
from kernel.model import lattice_chain
from kernel.quantities import QUANTITIES
from kernel.status import DONE
from kernel.task import M0, V0
from kernel.watch import largest_of, new_watch

GRADED, RANDOM = kernel.Graded(1.0, 3.0), kernel.Disordered(0.4, 5)
TASK = (9, 2e-3, 2.0, 2.0)


def test_disorder_follows_from_seed_and_place_alone():
    rng = np.random.default_rng()
    seed, n = int(rng.integers(2**32)), int(rng.integers(5, 200))
    law = kernel.Disordered(0.2, seed)
    here = law.values(n, "mass")
    assert here.tobytes() == law.values(3 * n, "mass")[:n].tobytes()
    assert np.abs(here - 1.0).max() <= 0.2
    assert not np.array_equal(here, law.values(n, "stiffness"))
    assert not np.array_equal(here, kernel.Disordered(0.2, (seed + 1) % 2**32).values(n, "mass"))
    many = law.values(100_000, "damping")
    assert many.mean() == pytest.approx(1.0, abs=2e-3)
    assert many.std() == pytest.approx(0.2 / np.sqrt(3.0), rel=0.02)


# Written down once: tables with disorder are only as lasting as these.
def test_disorder_keeps_its_bits_for_ever():
    assert kernel.Disordered(0.5, 42).values(2, "mass").tolist() == list(BITS)


BITS = (1.2739560485559633, 0.9388784397520523)


def test_every_problem_of_what_is_not_uniform_is_named_at_once():
    with pytest.raises(ValueError) as error:
        kernel.Model(
            mass=kernel.Graded(0.0, 1.0), stiffness=kernel.Disordered(1.0, -1), damping=[1.0, -2.0], wall="soft"
        )
    said = str(error.value)
    for word in ("mass.first", "stiffness.spread", "stiffness.seed", "damping[1]", "wall: must be one of fixed, free"):
        assert word in said, word
    with pytest.raises(ValueError, match="mass, damping: must hold as many numbers, got mass 2, damping 3"):
        kernel.Model(mass=[1.0, 2.0], damping=[1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match=r"model: holds lists of 2 numbers, which a chain of N = 9 cannot have"):
        kernel.ke_ratio(*TASK, model=kernel.Model(mass=[1.0, 2.0]))
    with pytest.raises(ValueError, match=r"mass: must be a number, \{ first = a"):
        model_of({"mass": {"frist": 1.0}})


@pytest.mark.parametrize("given", [GRADED, RANDOM, (1.0, 2.0, 0.5)], ids=["graded", "disordered", "listed"])
def test_settings_make_the_same_model_again(given):
    model = kernel.Model(mass=given, stiffness=2.0, wall="free")
    assert model_of(model.settings()) == model
    assert model.with_numbers(model.numbers()) == model
    assert not model.is_uniform


def by_scipy(N, zeta_T, M, V, model):
    """Largest |v_mid|, from the equations alone."""
    mass, stiffness, damping = (values_along(getattr(model, kind), N, kind) for kind in KINDS)
    tied = np.ones(N)
    tied[-1] = float(model.wall == "fixed")
    zeta, K, law = N * zeta_T, model.contact.stiffness / N**1.5, model.spring

    def rates(_, y):
        u, v = np.split(y, 2)
        e, slip = np.diff(u[1:], append=0.0), np.diff(v[1:], append=0.0)
        m = np.minimum(e, 0.0)
        pull = tied * (stiffness * (e + law.c2 * m**2 + law.c3 * m**3) + 2.0 * zeta * damping * slip)
        push = K * max(u[0] - u[1], 0.0) ** 1.5
        return np.concatenate([v, [-push / (N * M * M0)], np.diff(pull, prepend=-push) / mass])

    start = np.zeros(2 * N + 2)
    start[N + 1] = V * V0
    how = {"rtol": 1e-10, "atol": 1e-13, "max_step": 0.05, "dense_output": True}
    seen = solve_ivp(rates, (0.0, 2.25 * N), start, "DOP853", **how)
    site = N + 1 + (N + 1) // 2
    top = np.abs(seen.y[site]).argmax()
    near = np.linspace(seen.t[top - 1], seen.t[min(top + 1, len(seen.t) - 1)], 1000)
    return np.abs(seen.sol(near)[site]).max()


@pytest.mark.slow
@pytest.mark.parametrize(
    "model",
    [
        kernel.Model(mass=GRADED, stiffness=RANDOM, damping=kernel.Disordered(0.9, 1)),
        kernel.Model(wall="free"),
        kernel.Model(mass=np.linspace(2.0, 0.5, 9).tolist(), wall="free"),
    ],
    ids=["graded and disordered", "free", "listed and free"],
)
def test_what_is_not_uniform_runs_as_by_scipy_and_says_by_which_method(model):
    found = kernel.ke_ratio(*TASK, accuracy=1e-5, model=model)
    assert found.method == "rk45"
    site_mass, TE = values_along(model.mass, 9, "mass")[4], 0.5 * 9 * 2.0 * M0 * (2.0 * V0) ** 2
    assert found.ke_bistable * TE == pytest.approx(0.5 * site_mass * by_scipy(*TASK, model) ** 2, rel=1e-5)


def tightly(model, N, zeta_T):
    """Every quantity by its name, and the largest speed of the site, by tight Dormand-Prince."""
    chain = lattice_chain(N, zeta_T, 2.0 * M0, model.lattice(N))
    V, watch = 2.0 * V0 / chain.frequency, new_watch(tuple(QUANTITIES.values()))
    run = rk45.integrate(chain, V, 1e-8, 1e-11, 10**7, chain.t_end, watch)
    assert run.status == DONE
    found = dict(zip(QUANTITIES, largest_of(watch, chain, V), strict=True))
    return found | {"speed": run.speed * chain.frequency, "energy": run.energy / (0.5 * chain.impactor_mass * V * V)}


@pytest.mark.slow
def test_uniform_numbers_along_the_chain_are_the_uniform_chain():
    """Also where units are not those of the uniform chain: two routes to one answer."""
    model = kernel.Model(mass=2.0, stiffness=3.0, damping=0.7, site=0.25)
    along = kernel.Model(mass=[2.0] * 9, stiffness=[3.0] * 9, damping=[0.7] * 9, site=0.25)
    for zeta_T in (2e-3, 0.08):
        one, other = (tightly(model, 9, zeta_T) for model in (model, along))
        assert other == pytest.approx(one, rel=1e-4, abs=1e-6)


@pytest.mark.slow
def test_no_force_is_felt_where_there_is_no_wall():
    found = tightly(kernel.Model(mass=GRADED, damping=RANDOM, wall="free"), 9, 2e-3)
    assert found["wall_force"] == found["impulse"] == 0.0
    assert (8 * found["flipped"]).is_integer(), "the last link is none"
    assert 0.01 < found["dissipated"] == pytest.approx(1.0 - found["energy"])


@pytest.mark.slow
def test_where_the_only_link_of_a_chain_with_a_free_end_is_flipped_all_are():
    free, hit = kernel.Model(wall="free"), {"N": 2, "zeta_T": 0.05, "M_over_M0": 20.0, "V_over_V0": 5.0}
    assert kernel.measure(hit, "flipped", free)["flipped"].tolist() == [1.0]
    scene = kernel.Scene(2, 0.05, kernel.Impact(20, 5), model=free, observe="flipped")
    assert kernel.simulate(scene)["flipped"]["value"] == 1.0


@pytest.mark.slow
def test_energy_of_a_graded_chain_goes_into_its_dampers_alone():
    model = kernel.Model(mass=GRADED, stiffness=RANDOM, damping=RANDOM, wall="free")
    scene = kernel.Scene(20, 1e-3, kernel.Impact(2, 2), model=model, observe="energy")
    seen = kernel.simulate(scene, 1e-6)["energy"]
    assert np.abs(seen["total"] + seen["dissipated"] - 1.0).max() < 1e-5
    assert seen["dissipated"][-1] > 0.01


@pytest.mark.slow
def test_each_task_of_a_batch_has_the_disorder_of_its_own_seed_and_length():
    tasks = {"N": [9, 12, 9, 9], "zeta_T": 2e-3, "M_over_M0": 2.0, "V_over_V0": 2.0, "mass.seed": [1, 1, 2, -3]}
    rows = kernel.ke_ratios(tasks, model=kernel.Model(mass=kernel.Disordered(0.2)))
    assert rows["status"].tolist() == ["done"] * 3 + ["bad_input"]
    for row in rows[:3]:
        model = kernel.Model(mass=kernel.Disordered(0.2, int(row["mass.seed"])))
        assert kernel.ke_ratio(int(row["N"]), 2e-3, 2.0, 2.0, model=model).ke_ratio == row["ke_ratio"]
    assert len(set(rows["ke_ratio"][:3])) == 3


@pytest.mark.slow
def test_a_task_of_another_length_than_the_models_list_is_bad_input():
    tasks = {"N": [9, 3], "zeta_T": 2e-3, "M_over_M0": 2.0, "V_over_V0": 2.0}
    rows = kernel.ke_ratios(tasks, certify=False, model=kernel.Model(mass=[1.0, 2.0, 1.0]))
    assert rows["status"].tolist() == ["bad_input", "done"]


@pytest.mark.slow
def test_no_damper_takes_anything_where_all_are_listed_as_none():
    assert tightly(kernel.Model(damping=[0.0] * 9), 9, 2e-3)["dissipated"] == 0.0
