"""Compiled code does what plain Python does, and single precision what double precision does."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from kernel.integrate import run_by
from kernel.laws.power import PowerLaw
from kernel.laws.toda import Toda
from kernel.method import AFTERWARDS, EXPLICIT, IMPLICIT, SWITCH
from kernel.model import make_chain
from kernel.simd import DOUBLE, SINGLE
from kernel.splitting import (
    explicit,
    rules,
)
from kernel.task import V0
from kernel.watch import new_watch

from .splitting import LAWS, random_tasks, runs

SMALL = [(3, 1e-3, 1.0, 1.0), (18, 1e-3, 1.0, 0.3), (5, 0.0, 1.0, 1.0), (3, 0.5, 1.0, 1.0), (20, 0.5, 1.0, 1.0)]

PLAIN = """
import json
from tests.test_kernel_precision import SMALL, runs_of_both_precisions
for task in SMALL:
    print(json.dumps([[float(x) for x in run] for run in runs_of_both_precisions(*task)]))
"""


def runs_of_both_precisions(N, zeta_T, M, V):
    """By the scheme that serves it, in double precision and, where that is the explicit one, in single."""
    if N * zeta_T >= SWITCH:
        return [runs(N, zeta_T, M, V, 0.1, "bistable", IMPLICIT)[1]]
    return [runs(N, zeta_T, M, V, 0.1, "bistable", EXPLICIT, one)[1] for one in (DOUBLE, SINGLE)]


def test_compiled_code_does_what_plain_python_does():
    """In double precision to its rounding, which late, chaotic motion lets grow in the energy that is left.

    In single precision NumPy rounds otherwise, as its results are double where one operand is.
    """
    path = [*sys.path, str(Path(__file__).parent.parent)]  # the installed packages before the checkout's tests
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(path)}
    result = subprocess.run(
        [sys.executable, "-P", "-W", "error", "-c", PLAIN], env=environment, capture_output=True, text=True, timeout=120
    )
    assert result.returncode == 0, result.stderr
    for task, line in zip(SMALL, result.stdout.splitlines(), strict=True):
        (plain, *plain_single), (run, *single) = json.loads(line), runs_of_both_precisions(*task)
        assert [plain[0], *plain[3:6], plain[7]] == [run.status, run.steps, run.evaluations, *run[5:6], run.retries]
        assert plain[1:3] == pytest.approx([run.speed, run.t], rel=1e-12)
        assert plain[6] == pytest.approx(run.energy, rel=1e-8)
        for one, other in zip(plain_single, single, strict=True):
            assert one[1:3] == pytest.approx([other.speed, other.t], rel=2e-5)


@pytest.mark.parametrize("law", LAWS)
def test_single_precision_moves_a_peak_far_less_than_the_steps_do(law):
    """Measured: the largest relative difference of energies is 5e-6, a twentieth of the accuracy."""
    for N, zeta_T, M, V in random_tasks(60, 12, 120):
        if N * zeta_T >= SWITCH:
            continue
        (chain, double), (_, single) = (runs(N, zeta_T, M, V, 1e-4, law, EXPLICIT, one) for one in (DOUBLE, SINGLE))
        rule = rules.explicit_rule(chain, 1e-4)
        near = explicit.run_explicit(chain, V * V0, rule, rule, 10**8, 1e-6, new_watch(()), DOUBLE)
        sensitive = abs((near.speed / double.speed) ** 2 - 1) / 1e-6 > 30
        assert sensitive or abs((single.speed / double.speed) ** 2 - 1) < 2e-5, (N, zeta_T, M, V)


@pytest.mark.parametrize("law", [PowerLaw(1.5, 100.0), PowerLaw(3.0, 100.0), PowerLaw(1.5, 1.0), Toda(1e-3)])
def test_single_precision_tells_the_small_bend_of_a_spring_that_is_hardly_strained(law):
    """Strains are 1e-5 of the precompression: 1 - e/d in single precision would be off by a hundredth of e/d."""
    chain, V = make_chain(40, 1e-4, 1.0, bistable=True)._replace(spring=law), 0.01 * V0
    rule = rules.explicit_rule(chain, 1e-3)
    double, single = (
        explicit.run_explicit(chain, V, rule, rule, 10**8, 0.0, new_watch(()), one) for one in (DOUBLE, SINGLE)
    )
    assert (single.speed / double.speed) ** 2 == pytest.approx(1.0, abs=2e-5)


@pytest.mark.parametrize(("spring", "kept"), [(PowerLaw(6.0, 0.0), DOUBLE), (PowerLaw(1.5, 0.01), SINGLE)])
def test_grains_that_only_touch_are_kept_in_double_precision_and_pressed_ones_need_not_be(spring, kept):
    """The tension of the former is far below their strain, from which single precision could not tell it."""
    chain, V = make_chain(20, 0.0, 1.0, bistable=True)._replace(spring=spring), V0
    rule, later = rules.explicit_rule(chain, 1e-3), rules.explicit_rule(chain, AFTERWARDS)
    run = explicit.run_explicit(chain, V, rule, later, 10**8, 0.0, new_watch(()), kept)
    assert run_by(EXPLICIT, chain, V, 0.0, 1e-3, 10**8, new_watch(())) == run
