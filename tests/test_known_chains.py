"""Chains whose motion others have worked out: exact solutions and published laws, with the digits that are reached.

Toda: the soliton of M. Toda, J. Phys. Soc. Jpn. 22 (1967) 431. With the tension (1 - exp(-b e)) / b and strains e_i,
exp(-b e_i) - 1 = beta^2 sech^2(kappa i - beta t), beta = sinh kappa. Linear: E. Schroedinger, Ann. Phys. 44 (1914) 916:
a site that is given the speed 1 in an infinite chain, v_n = J_2n(2t). Hertz: V. F. Nesterenko, J. Appl. Mech. Tech.
Phys. 24 (1983) 733: the solitary wave of an uncompressed chain travels at a speed that goes with the power 1/5 of the
grains' largest velocity and is about five grains wide, whatever its amplitude. E. J. Hinch and S. Saint-Jean, Proc. R.
Soc. A 455 (1999) 3201: struck by one grain, it has 0.682 of its velocity. E. Fermi, J. Pasta, S. Ulam and M. Tsingou,
Los Alamos report LA-1940 (1955), figure 1: 32 masses, alpha = 1/4, all in the first mode of amplitude 1; by T. Dauxois,
Physics Today 61 (2008) 55, it comes back after 157 periods.
"""

import numpy as np
import pytest
from scipy.special import jv

import kernel
from kernel.task import M0, V0

from .test_known_grains import crest

pytestmark = pytest.mark.slow


def released(N, u, v, spring, t_end, at):
    """Velocities of all sites at the times `at` (over N)."""
    model = kernel.Model(spring=spring, t_end=t_end)
    scene = kernel.Scene(N, 0.0, kernel.Release(u, v), model=model, observe={"profile": {"at": at}})
    seen = kernel.simulate(scene, 1e-8)
    assert seen.status == "done"
    return seen["profile"]["v"]


def toda(b, kappa, centre, i, t):
    """Displacement and velocity of the sites i, 0 far to the right; the soliton travels to the right, compressing."""
    beta = np.sinh(kappa)
    # s_i = log cosh(kappa i - beta t) solves the chain: b u_i = s_(i-1) - s_i but for a constant.
    x = kappa * (i - centre) - beta * t
    before, here = np.logaddexp(x - kappa, kappa - x), np.logaddexp(x, -x)
    speed = beta / b * (np.tanh(x) - np.tanh(x - kappa))
    return (before - here + kappa) / b, speed


def test_todas_soliton_travels_as_it_is_exactly():
    N, b, kappa, end = 120, 2.0, 1.0, 30.0
    i = np.arange(1, N + 1)
    u, v = toda(b, kappa, 40.0, i, 0.0)
    (found,) = released(N, u, v, kernel.Toda(b), 0.3, [end / N])
    _, true = toda(b, kappa, 40.0, i, end)
    top = np.abs(true).max()
    assert top > 0.3, "a wave of large amplitude"
    assert np.abs(found - true).max() < 1e-8 * top


def test_a_site_of_the_linear_chain_moves_as_bessels_functions():
    N, start, end = 120, 60, 25.0
    v = np.zeros(N)
    v[start - 1] = 1.0
    (found,) = released(N, np.zeros(N), v, kernel.Bistable(0.0, 0.0), 0.3, [end / N])
    true = jv(2 * np.abs(np.arange(1, N + 1) - start), 2.0 * end)
    assert np.abs(found - true).max() < 1e-10


def solitary(V):
    """Speed, largest velocity and width in grains of the first wave in an uncompressed Hertz chain."""
    N, links = 150, kernel.PowerLaw(1.5, 0.0)
    model = kernel.Model(spring=links, t_end=0.95 / V**0.2, contact=kernel.Hertz(N**1.5))
    # The impactor has the mass of a grain, and meets the first one as grains meet.
    impact = kernel.Impact(1.0 / (N * M0), V / V0)
    scene = kernel.Scene(N, 0.0, impact, model=model, observe={"ke_field": {"times": 3001}})
    seen = kernel.simulate(scene, 1e-6)["ke_field"]
    speeds, t = np.sqrt(2 * seen["ke"] * scene.TE), seen["t"] * N
    near, far = 60 - 1, 100 - 1
    first, last = (crest(t, speeds[:, site]) for site in (near, far))
    speed = (far - near) / (last[0] - first[0])
    half = np.ptp(t[speeds[:, far] > 0.5 * last[1]])
    return speed, last[1], speed * half


def test_the_solitary_wave_of_an_uncompressed_hertz_chain_is_nesterenkos():
    slow, fast = solitary(0.05), solitary(0.8)
    exponent = np.log(fast[0] / slow[0]) / np.log(fast[1] / slow[1])
    assert exponent == pytest.approx(0.2, abs=1e-9)
    # Nesterenko's continuum, whose prefactor is (4/5)^(2/5) = 0.9146, is a percent too fast for waves so short.
    assert slow[0] / slow[1] ** 0.2 == pytest.approx(0.8**0.4, rel=1e-2)
    assert slow[2] == pytest.approx(fast[2], rel=1e-6), "the width does not depend on the amplitude"
    # In the continuum cos^4 of a wave five grains long: half of its velocity is exceeded over 1.82 of them.
    assert 1.4 < slow[2] < 1.9


def test_sound_in_a_hertz_chain_under_precompression_travels_at_one_site_per_unit_of_time():
    """The unit of time is that of the stiffness at rest, n A d^(n-1): whatever the precompression."""
    N = 100
    for d in (1e-2, 1.0):
        v = np.zeros(N)
        v[:] = 1e-6 * d * np.exp(-(((np.arange(N) - 30) / 8.0) ** 2))
        at = [0.0, 0.4]
        found = released(N, np.zeros(N), v, kernel.PowerLaw(1.5, d), 0.45, at)
        right = found[1][50:]  # half of it travels to the right
        centre = 50 + (right * np.arange(len(right))).sum() / right.sum()
        assert centre - 30 == pytest.approx(0.4 * N, rel=2e-3)


def test_a_hertz_chain_struck_by_one_grain_takes_on_0682_of_its_velocity():
    """Published to three digits, which are reached; here 0.68163, whatever the velocity."""
    V = 0.3
    _, top, _ = solitary(V)
    assert top / V == pytest.approx(0.682, abs=5e-4)


def test_the_first_mode_of_fermi_pasta_ulam_and_tsingous_chain_comes_back():
    """Not after the 157 periods that are quoted, but after 153.4, with 98 % of its energy.

    The report's own steps, 1/sqrt(8) of leapfrog, bring it back after 164 (30 700 steps; its figure ends at 30 000):
    they lessen the chain's dispersion by an eighth. With steps of 0.1 leapfrog is within a period of what is found.
    """
    N, alpha = 33, 0.25  # the first site is the left wall
    start = np.sin(np.pi * np.arange(N) / N)
    mode, omega = np.sqrt(2.0 / N) * start, 2.0 * np.sin(0.5 * np.pi / N)
    period, last = 2.0 * np.pi / omega, 170

    def back(u, v, t):
        """When the first mode has most of its energy again, in its periods, and how much of it."""
        energy = 0.5 * (v @ mode) ** 2 + 0.5 * (omega * u @ mode) ** 2
        late = t > 100 * period
        assert (energy / energy[0]).min() < 0.1, "nearly all of it has gone to others"
        return t[late][energy[late].argmax()] / period, energy[late].max() / energy[0]

    at = np.linspace(0.0, last * period / N, 8 * last + 1)
    model = kernel.Model(spring=kernel.Polynomial(c2=alpha), t_end=at[-1])
    event = kernel.Release(start, np.zeros(N), hold=True)
    seen = kernel.simulate(kernel.Scene(N, 0.0, event, model=model, observe={"profile": {"at": at}}), 1e-7)
    assert seen.status == "done"
    when, share = back(seen["profile"]["u"], seen["profile"]["v"], at * N)
    assert when == pytest.approx(153.4, abs=0.2)
    assert share == pytest.approx(0.9807, abs=1e-3)
    for step, true in ((0.1, when), (np.sqrt(1 / 8), 164.2)):
        assert back(*_leapfrog(start, alpha, step, last * period))[0] == pytest.approx(true, abs=1.0)


def _leapfrog(u, alpha, h, end):
    """Displacements, velocities and times of a chain between two walls, from rest, every few steps."""
    u, v, kept = u.copy(), np.zeros_like(u), []

    def force():
        e = np.diff(u, append=0.0)
        return np.diff(e + alpha * e * e, prepend=0.0)

    a, every = force(), round(8.0 / h)
    a[0] = 0.0
    for k in range(int(end / h)):
        if k % every == 0:
            kept.append((u.copy(), v.copy(), k * h))
        v += 0.5 * h * a
        u += h * v
        a = force()
        a[0] = 0.0
        v += 0.5 * h * a
    return tuple(np.array(x) for x in zip(*kept, strict=True))
