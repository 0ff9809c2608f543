"""Published set-ups of grains that touch, with the numbers that were printed, and where one does not come out, why.

The numbers are quoted as the literature has them, without the papers at hand; each is also held against what is derived
or computed here in another way. All chains are of Hertz's contacts, struck by one grain, and none is damped.

- E. J. Hinch and S. Saint-Jean, Proc. R. Soc. A 455 (1999) 3201: a line of balls with a free end flies apart.
- J. M. English and R. L. Pego, Proc. Am. Math. Soc. 133 (2005) 1763: the solitary wave r of the overlaps, without a
  continuum, as the fixed point of c^2 r = tent * r^(3/2), a convolution.
- S. Sen and M. Manciu, Physica A 268 (1999) 644: its displacement (1 - tanh(f/2))/2, f = 2.39536 z + 0.268529 z^3 +
  0.0061347 z^5, z in grains.
- V. F. Nesterenko (1983), C. Coste, E. Falcon and S. Fauve, Phys. Rev. E 56 (1997) 6104, and C. Daraio, V. F.
  Nesterenko, E. B. Herbold and S. Jin, Phys. Rev. E 73 (2006) 026610: speed from force, with the prefactors 0.6802
  without and 0.9314 with precompression, in spheres' own units.
- K. R. Jayaprakash, Y. Starosvetsky and A. F. Vakakis, Phys. Rev. E 83 (2011) 036606: in a chain of heavy and light
  grains a pulse loses nothing at the mass ratios 0.3428, 0.1548, 0.0901, ...
"""

import numpy as np
import pytest

import kernel
from kernel.task import M0, V0

pytestmark = pytest.mark.slow

SPHERES = 6.0 ** (-1 / 3) * np.sqrt(6.0 / np.pi)  # from speeds in unit grains and contacts to the papers' prefactors


def struck(N, at, d=0.0, V=1.0, **model):
    """Times, displacements and velocities of a chain that a grain of its own kind strikes at V; d: precompression."""
    model = kernel.Model(kernel.PowerLaw(1.5, d), kernel.Hertz(N**1.5), t_end=at[-1] / N, **model)
    impact = kernel.Impact(1.0 / (N * M0), V / V0)
    scene = kernel.Scene(N, 0.0, impact, model=model, observe={"profile": {"at": at / N}})
    seen = kernel.simulate(scene, 1e-8)
    assert seen.status == "done"
    return at, seen["profile"]["u"], seen["profile"]["v"]


def crest(t, x):
    """Time and height of the parabola through the three highest samples."""
    k = int(x.argmax())
    a, b, c = x[k - 1 : k + 2]
    shift = 0.5 * (a - c) / (a - 2 * b + c)
    return t[k] + shift * (t[1] - t[0]), b - 0.25 * (a - c) * shift


def test_a_line_of_balls_flies_apart_as_hinch_and_saint_jean_have_it():
    """Of the impact speed the last ball takes 0.986, the one before 0.149; the impactor returns with 0.071."""
    _, _, v = struck(50, np.array([250.0, 500.0]), wall="free")
    assert np.abs(v[0] - v[1]).max() < 1e-6, "all have parted"
    assert v[1, -2:] == pytest.approx([0.149, 0.986], abs=5e-4)
    assert 1.0 - v[1].sum() == pytest.approx(-0.071, abs=5e-4), (
        "what the momentum of the others leaves for the impactor"
    )
    assert (np.diff(v[1, :30]) > 0).all(), "the others follow the impactor, the slower the deeper"


def solitary_wave(steps=128):
    """English and Pego's wave of largest overlap 1: places, overlaps, speed; `steps` a grain."""
    x = np.arange(-12 * steps, 12 * steps + 1) / steps
    tent = np.maximum(0.0, 1.0 - np.abs(np.arange(-steps, steps + 1) / steps)) / steps
    r, before = np.exp(-x * x), np.zeros_like(x)
    while np.abs(r - before).max() > 1e-13:
        raised = np.convolve(r**1.5, tent, "same")
        before, r = r, raised / raised.max()
    return x, r, np.sqrt(raised.max())


@pytest.fixture(scope="module")
def wave():
    """Times, displacements, velocities and crests of two grains, far from the end, that a solitary wave passes."""
    t, u, v = struck(120, np.arange(40.0, 110.0, 0.01))
    return t, u, v, crest(t, v[:, 69]), crest(t, v[:, 89])


def test_the_solitary_wave_is_the_one_of_english_and_pego(wave):
    x, r, true = solitary_wave()
    t, u, _, (start, _), (end, top) = wave
    speed = 20.0 / (end - start)
    overlap = -np.diff(u, axis=1)[:, 88]
    assert speed / overlap.max() ** 0.25 == pytest.approx(true, rel=2e-6)
    # A grain's velocity from the momentum that the two contacts pass: c v = the force over one grain's length.
    through = np.convolve(r**1.5, np.r_[0.5, np.ones(127), 0.5] / 128, "same") / true
    assert speed / top**0.2 == pytest.approx(true / through.max() ** 0.2, rel=1e-5)
    shape = np.interp(speed * (t - t[overlap.argmax()]), x, r)
    assert np.abs(overlap / overlap.max() - shape).max() < 5e-3  # a sample is 0.01 of the time, 0.008 grains


def test_the_solitary_waves_displacement_is_sen_and_mancius(wave):
    """Their three coefficients are those of its series to 5e-5, 6e-4 and 2 %."""
    t, u, _, (start, _), (end, _) = wave
    z = 20.0 / (end - start) * (t - start)
    done = u[:, 69] / u[-1, 69]
    near = np.abs(z) < 1.0
    f, odd = np.log(done[near] / (1.0 - done[near])), z[near, None] ** np.arange(1, 10, 2)
    found = np.linalg.lstsq(odd, f)[0]
    for k, (printed, digits) in enumerate(((2.39536, 1e-4), (0.268529, 1e-3), (0.0061347, 0.03))):
        assert found[k] == pytest.approx(printed, rel=digits)
    theirs = 0.5 * (1.0 + np.tanh(0.5 * (2.39536 * z + 0.268529 * z**3 + 0.0061347 * z**5)))
    assert np.abs(done - theirs)[np.abs(z) < 3.0].max() < 3e-4


def test_the_prefactor_06802_of_speed_and_force_is_the_continuums_and_grains_have_06887():
    """It does not come out, and no finer computation would bring it: 0.6802 is 2/sqrt(5) of Nesterenko's long waves.

    His is five grains long, too short for a continuum that stops at the fourth derivative: 1.2 % too slow at a force.
    """
    assert 2.0 / np.sqrt(5.0) * SPHERES == pytest.approx(0.6802, abs=5e-5)
    assert np.sqrt(1.5) * SPHERES == pytest.approx(0.9314, abs=1e-4), "sound under precompression has no such error"
    assert solitary_wave()[2] * SPHERES == pytest.approx(0.6887, abs=5e-5)


@pytest.mark.parametrize(("d", "V", "found"), [(1.0, 5.0, 0.0024), (0.1, 3.0, 0.0077), (0.01, 3.0, 0.0113)])
def test_waves_under_precompression_have_the_speed_that_follows_from_their_force(d, V, found):
    """c/c0 = sqrt(4/15 (3 + 2 f^(5/3) - 5 f^(2/3))) / (f^(2/3) - 1), f = largest force over that at rest.

    Again a continuum's: the stronger the wave, the shorter, and the nearer to the 1.2 % that are found without
    precompression.
    """
    t, u, _ = struck(160, np.arange(10.0, 135.0, 0.02), d, V)
    strains = np.diff(u, axis=1)
    (start, _), (end, overlap) = crest(t, -strains[:, 89]), crest(t, -strains[:, 119])
    f = (1.0 + overlap / d) ** 1.5
    printed = np.sqrt(4 / 15 * (3 + 2 * f ** (5 / 3) - 5 * f ** (2 / 3))) / (f ** (2 / 3) - 1)
    assert f > 5.0, "strongly nonlinear"
    assert 30.0 / (end - start) / printed - 1.0 == pytest.approx(found, abs=1e-4)


def lost(ratio):
    """Share of its velocity that a pulse loses over 40 pairs of a heavy grain and a light one."""
    N = 200
    mass = np.where(np.arange(N) % 2 == 0, 1.0, ratio)
    t, _, v = struck(N, np.arange(60.0, 170.0, 0.02), mass=mass)
    return 1.0 - crest(t, v[:, 160])[1] / crest(t, v[:, 80])[1]


@pytest.mark.parametrize("printed", [0.3428, 0.1548, 0.0901])
def test_a_pulse_loses_nothing_at_the_mass_ratios_of_jayaprakash_starosvetsky_and_vakakis(printed):
    low, high = 0.98 * printed, 1.02 * printed
    less, more = np.sqrt(lost(low)), np.sqrt(lost(high))
    assert min(less, more) ** 2 > 5e-5
    assert lost(printed) < 1e-6
    # What is lost is a square, of a number that changes sign.
    assert (low * more + high * less) / (less + more) == pytest.approx(printed, abs=5e-4)
