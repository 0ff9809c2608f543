"""On random tasks of a fresh seed, each method converges by itself and the certified promises hold.

The programs ask more and say more: python -m tests.convergence, python -m tests.promises --random 1000.
"""

import secrets

import numpy as np
import pytest

from . import convergence, promises, truth

LONGEST = 60  # sites
SHARE = 0.05  # of the tasks that may miss a bound that 1 % miss in a long run of the program


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


@pytest.mark.parametrize("accuracy", [1e-1, 1e-3, 3e-4, 1e-5])
def test_each_chain_alone_is_within_three_accuracies_not_certified(seed, drawn, accuracy):
    tasks, true = drawn
    error, well = convergence.errors(tasks, true.KE, accuracy), true.condition < convergence.WELL
    for chain in range(2):
        some = error[well[:, chain], chain]
        assert np.mean(some > convergence.MOSTLY) < SHARE, f"seed {seed}"
        assert np.mean(some > 10 * convergence.NEVER) < SHARE / 5, f"seed {seed}"


def test_no_chain_has_a_floor(seed, drawn):
    tasks, true = drawn
    fair = true.condition < convergence.FAIR
    coarse, fine = (convergence.errors(tasks, true.KE, a) * a for a in (1e-4, 3e-6))
    for chain in range(2):
        assert np.median(fine[fair[:, chain], chain]) < 0.2 * np.median(coarse[fair[:, chain], chain]), f"seed {seed}"
        assert np.quantile(fine[fair[:, chain], chain], 0.95) < 1e-4, f"seed {seed}"


@pytest.mark.parametrize("target", [1e-2, 1e-3, 1e-4])
def test_certified_rows_keep_their_promises(seed, drawn, target):
    tasks, true = drawn
    k = promises.kept(promises.judged_by(tasks, true), target)
    assert k.within > 1 - SHARE / 2, f"seed {seed}"
    assert k.covered > 1 - SHARE, f"seed {seed}"
    assert k.false < SHARE, f"seed {seed}"
