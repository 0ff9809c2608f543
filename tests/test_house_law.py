"""A spring law and a contact from outside of the kernel, stated once, run through every integrator that there is."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kernel
from kernel import rk45
from kernel.integrate import run_by
from kernel.laws.any_power import impulse_of_power
from kernel.method import EXPLICIT, IMPLICIT
from kernel.model import LINEAR, lattice_chain
from kernel.status import DONE
from kernel.task import V0
from kernel.watch import new_watch

pytestmark = pytest.mark.slow


class CubicQuintic(NamedTuple):
    """Tension e + a e^3 + b e^5, the same in tension and in compression; a, b >= 0."""

    a: float
    b: float

    def excess(self, e):
        return e * e * e * (self.a + self.b * e * e)

    def energy_at(self, e):
        return e * e * (0.5 + e * e * (self.a / 4.0 + self.b / 6.0 * e * e))

    def stiffness_at(self, e):
        return 1.0 + e * e * (3.0 * self.a + 5.0 * self.b * e * e)

    def steepest(self, lowest, highest):
        return max(self.stiffness_at(lowest), self.stiffness_at(highest))

    def is_linear(self):
        return self.a == 0.0 and self.b == 0.0

    def stiffens_in_tension(self):
        return True

    def stiffness_jumps(self):
        return False


class Elastic(NamedTuple):
    """F = K d where the bodies overlap by d > 0, else 0."""

    K: float

    def push(self, d):
        return self.K * max(d, 0.0)

    def energy_at(self, d):
        return 0.5 * self.K * max(d, 0.0) ** 2

    def stiffness_at(self, d):
        return self.K

    def period(self, mass, energy):
        return math.sqrt(mass / self.K)

    def duration(self, lightness, V):
        return math.pi / math.sqrt(self.K * lightness)

    def after(self, d, change):
        return d + change / self.K

    def overlap(self, free, softness, guess):
        return max(free, 0.0) / (1.0 + softness * self.K)

    def impulse(self, d, free, softness):
        return impulse_of_power(self.K, 1.0, d, free, softness)

    def at_unit_speed(self, V):
        return self

    def of_cells(self, N):
        return Elastic(self.K / N)

    def softened(self, by):
        return Elastic(self.K / by)


LAW = CubicQuintic(3.0, 5.0)
MODEL = kernel.Model(spring=LAW, contact=Elastic(2e3))


def true_peak(N, zeta_T, M, V):
    """Largest |v_mid| by scipy, from the equations alone."""
    chain = lattice_chain(N, zeta_T, M, MODEL.lattice())

    def rates(_, y):
        u, v = np.split(y, 2)
        e, slip = np.diff(u[1:], append=0.0), np.diff(v[1:], append=0.0)
        pull = e + LAW.a * e**3 + LAW.b * e**5 + 2.0 * chain.zeta * slip
        push = 2e3 / N * max(u[0] - u[1], 0.0)
        return np.concatenate([v, [-push / chain.impactor_mass], np.diff(pull, prepend=-push)])

    start = np.zeros(2 * N + 2)
    start[N + 1] = V
    seen = solve_ivp(rates, (0.0, 2.25 * N), start, "DOP853", rtol=1e-10, atol=1e-13, max_step=0.02, dense_output=True)
    middle = N + 1 + (N + 1) // 2
    top = np.abs(seen.y[middle]).argmax()
    near = np.linspace(seen.t[top - 1], seen.t[min(top + 1, len(seen.t) - 1)], 1000)
    return np.abs(seen.sol(near)[middle]).max()


@pytest.mark.parametrize(("zeta_T", "method"), [(1e-3, EXPLICIT), (0.08, IMPLICIT)])
def test_a_law_from_outside_runs_by_rk45_and_by_both_splittings(zeta_T, method):
    N, M, V = 12, 0.3, 2.0 * V0
    chain, true = lattice_chain(N, zeta_T, M, MODEL.lattice()), true_peak(N, zeta_T, M, V)
    tight = rk45.integrate(chain, V, 1e-9, 1e-12, 10**7, 2.25 * N, new_watch(()))
    assert tight.status == DONE
    assert tight.speed == pytest.approx(true, rel=1e-6)
    fast = run_by(method, chain, V, 0.0, 1e-4, 10**7, new_watch(()))
    assert fast.status == DONE
    assert fast.speed == pytest.approx(true, rel=3e-4)
    linear = run_by(method, chain._replace(spring=LINEAR), V, 0.0, 1e-4, 10**7, new_watch(()))
    assert linear.speed != pytest.approx(true, rel=0.01), "the law matters"


def test_a_law_without_a_barrier_is_a_model_all_the_same_and_only_who_asks_which_links_flip_is_refused():
    model, hit = kernel.Model(LAW), kernel.Impact(1, 1)
    told = "flipped: needs a spring law with the method barrier, got CubicQuintic"
    with pytest.raises(ValueError, match=f"accuracy: .*; observe: {told}"):
        kernel.measure({"N": 6, "zeta_T": 0, "M_over_M0": 1, "V_over_V0": 1}, ["ke", "flipped"], model, accuracy=1)
    with pytest.raises(ValueError, match=f"observe: {told}"):
        kernel.Scene(6, 0, hit, observe=("stored", "flipped"), model=model)
    assert kernel.Scene(6, 0, hit, observe="stored", model=model)
    assert kernel.Scene(6, 0, hit, "linear", "flipped", model), "the linear chain's law has one"


def test_a_law_that_lacks_methods_is_refused_in_words_that_name_them():
    with pytest.raises(ValueError, match=r"contact: must be a law as kernel\.Hertz, got CubicQuintic") as raised:
        kernel.Model(contact=LAW)
    assert "a law of your own: it lacks push, period, duration, after, overlap, impulse, at_unit" in str(raised.value)


class Rational(CubicQuintic):
    """Tension e / (1 + |e| / a)."""

    def excess(self, e):
        return e / (1.0 + abs(e) / self.a) - e


class OfNumpy(CubicQuintic):
    def excess(self, e):
        return np.tanh(e) - e


class OfMath(CubicQuintic):
    def excess(self, e):
        return math.sinh(e) - e


class Branching(CubicQuintic):
    def excess(self, e):
        return e if e > 0.0 else 0.0 * e


@pytest.mark.parametrize(("law", "used"), [(OfNumpy, "tanh"), (OfMath, "sinh"), (Branching, "gt")])
def test_a_law_whose_tension_several_strains_at_once_cannot_have_is_refused_in_one_line(law, used):
    with pytest.raises(ValueError, match=rf"spring: its method excess must do with .*, got {used} \(.*, line \d+\)$"):
        kernel.Model(spring=law(1.0, 2.0))
    assert kernel.Model(spring=Rational(1.0, 0.0)), "abs is known"
