"""On random tasks of a fresh seed, each method converges by itself and the certified promises hold.

A share of the tasks may miss a bound. Each test allows as many as so large a share does but with a chance of CHANCE: it
fails where what is stated is broken, not now and then. The programs ask more and say more: python -m tests.convergence,
python -m tests.promises --random 1000.
"""

import secrets

import numpy as np
import pytest
from scipy.stats import binom

from . import convergence, promises, truth

pytestmark = pytest.mark.slow

LONGEST = 60  # sites
CHANCE = 1e-6  # that a test fails though what is stated holds
FAR = 10 * convergence.NEVER  # accuracies: what the program calls never, and then ten times that
MISSES = {convergence.MOSTLY: 0.01, FAR: 1e-4}  # shares of tasks beyond so many accuracies, with room above the stated


@pytest.fixture(scope="module")
def seed():
    return secrets.randbelow(2**31)


@pytest.fixture(scope="module")
def drawn(seed):
    """About 190 tasks with both chains' true peaks and condition numbers."""
    tasks = truth.draw(200, seed, LONGEST)
    soft = ~truth.stiff(tasks) & (tasks["N"] <= LONGEST)
    tasks = {name: values[soft] for name, values in tasks.items()}
    return tasks, truth.truth_here(tasks)


def most(share, tasks):
    """How many of so many tasks may miss a bound that this share of all may miss."""
    return binom.isf(CHANCE, tasks, share)


@pytest.mark.parametrize("accuracy", [1e-1, 1e-3, 3e-4, 1e-5])
def test_each_chain_alone_is_within_three_accuracies_not_certified(seed, drawn, accuracy):
    tasks, true = drawn
    error, well = convergence.errors(tasks, true.KE, accuracy), true.condition < convergence.WELL
    for chain in range(2):
        some = error[well[:, chain], chain]
        for bound, share in MISSES.items():
            assert np.sum(some > bound) <= most(share, len(some)), f"seed {seed}, beyond {bound:g} accuracies"


def test_no_chain_has_a_floor(seed, drawn):
    tasks, true = drawn
    fair = true.condition < convergence.FAIR
    coarse, fine = (convergence.errors(tasks, true.KE, a) * a for a in (1e-4, 3e-6))
    for chain in range(2):
        some = fine[fair[:, chain], chain]
        assert np.median(some) < 0.2 * np.median(coarse[fair[:, chain], chain]), f"seed {seed}"
        assert np.sum(some > 1e-4) <= most(0.02, len(some)), f"seed {seed}"


@pytest.mark.parametrize("target", [1e-2, 1e-3, 1e-4])
def test_certified_rows_keep_their_promises(seed, drawn, target):
    tasks, true = drawn
    data = promises.judged_by(tasks, true)
    k, well = promises.kept(data, target), int((data["condition"] < promises.WELL_CONDITIONED).sum())
    calm = int((data["condition"] <= promises.CHAOTIC).sum())
    assert (1 - k.within) * well <= most(0.05, well), f"seed {seed}"
    assert (1 - k.covered) * calm <= most(0.05, calm), f"seed {seed}"
    assert k.false * calm <= most(0.05, calm), f"seed {seed}"
