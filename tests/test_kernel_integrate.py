"""Which integrator "auto" takes for the bistable chain, and that it is right about it."""

import numpy as np
import pytest

import kernel
from kernel.integrate import method_of
from kernel.method import DORMAND_PRINCE, RK45, SWITCH, choose, looser, methods_of

SHORT, LONG = (18, 0.08, 6.0, 1.5), (200, 0.05, 1.0, 1.0)  # N zeta_T: 1.4 and 10
MODERATE = (125, 0.0045, 0.6, 1.1)  # 0.56


@pytest.mark.parametrize(
    ("task", "accuracy", "method"),
    [
        (SHORT, 1e-3, "rk45"),
        (SHORT, 1e-5, "rk45"),
        (LONG, 1e-3, "implicit"),
        (LONG, 1e-5, "implicit"),
        (MODERATE, 1e-3, "implicit"),
        (MODERATE, 1e-5, "rk45"),
        ((18, 0.01, 6.0, 1.5), 1e-5, "explicit"),
    ],
)
def test_auto_takes_the_method_of_the_physics_and_reaches_its_target(task, accuracy, method):
    exact = kernel.ke_ratio(*task, method="rk45", rtol=1e-10, certify=False).ke_ratio
    row = kernel.ke_ratio(*task, accuracy=accuracy)
    assert row.method == method
    assert row.ke_ratio == pytest.approx(exact, rel=accuracy)
    assert abs(row.ke_ratio / exact - 1) <= row.error


def test_the_more_accurate_the_longer_and_the_more_damped_chains_dormand_prince_serves():
    def longest(zeta, accuracy):
        integrator = choose()._replace(accuracy=accuracy)
        served = (N for N in range(2, 10_000) if method_of(N, zeta, False, integrator) == DORMAND_PRINCE)
        return max(served, default=0)

    assert longest(0.99 * SWITCH, 1e-5) == 0
    assert longest(SWITCH, 3e-6) == 9999, "what the impact takes no longer counts"
    assert longest(SWITCH, 1e-3) < longest(SWITCH, 1e-4) < longest(SWITCH, 5e-5)
    assert longest(0.5, 1e-4) > longest(2.0, 1e-4) > longest(8.0, 1e-4) > 2


def test_both_tolerances_of_a_companion_are_looser_by_the_same():
    own = choose("rk45", rtol=1e-7)
    companion = looser(own)
    assert companion.rtol > own.rtol
    assert companion.atol / companion.rtol == pytest.approx(own.atol / own.rtol)


def test_the_choice_for_many_chains_is_the_compiled_one_for_each():
    rng = np.random.default_rng(8)
    N, zeta = rng.integers(2, 2000, 500), np.where(rng.random(500) < 0.1, 0.0, 10.0 ** rng.uniform(-4, 3, 500))
    for integrator in (choose()._replace(accuracy=a) for a in (1e-2, 1e-4, 1e-6)):
        for linear in (True, False):
            for asked in (integrator, integrator._replace(kind=RK45)):
                each = [method_of(int(n), float(z), linear, asked) for n, z in zip(N, zeta, strict=True)]
                assert methods_of(N, zeta, linear, asked).tolist() == each
