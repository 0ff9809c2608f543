"""ke_ratio: converged references, symmetry, error estimate, bad input."""

import math
import os
import subprocess
import sys
from ast import literal_eval
from dataclasses import astuple

import numpy as np
import pytest

import kernel
from kernel import rk45
from kernel.laws.hertz import ThreeHalves
from kernel.model import make_chain
from kernel.task import V0
from kernel.watch import new_watch

PARAMETERS = ("N", "zeta_T", "M_over_M0", "V_over_V0")
GOOD = {"N": 10, "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": 1.0}


def test_at_tight_tolerance_every_well_conditioned_reference_case_agrees(reference):
    cases = [case for case in reference if case["condition"] < 100]
    assert len(cases) >= 16
    for case in cases:
        task = {name: case[name] for name in PARAMETERS}
        r = kernel.ke_ratio(**task, method="rk45", rtol=1e-9, atol=1e-12)
        for name in ("ke_ratio", "ke_bistable", "ke_linear"):
            assert getattr(r, name) == pytest.approx(case[name], rel=5e-6), (name, task)
        for name in ("t_peak_bistable", "t_peak_linear"):
            assert getattr(r, name) == pytest.approx(case[name], abs=1e-3), (name, task)


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3, 1e-4])
def test_auto_reaches_the_wanted_accuracy_on_the_reference_cases(reference, accuracy):
    for case in reference:
        r = kernel.ke_ratio(**{name: case[name] for name in PARAMETERS}, accuracy=accuracy)
        assert r.ke_ratio == pytest.approx(case["ke_ratio"], rel=accuracy), case
        assert abs(r.ke_ratio / case["ke_ratio"] - 1) <= r.error, "the estimate covers the true error"


def test_ke_ratio_is_the_quotient_of_its_parts_and_certify_changes_only_the_error():
    calm = {"N": 60, "zeta_T": 1e-2, "M_over_M0": 1.0, "V_over_V0": 1.0}
    certified, plain = (kernel.ke_ratio(**calm, certify=certify) for certify in (True, False))
    assert certified.ke_ratio == pytest.approx(certified.ke_bistable / certified.ke_linear, rel=1e-14)
    assert plain.ke_ratio == certified.ke_ratio
    assert math.isnan(plain.error)
    assert 0 < certified.error < 1e-2
    assert plain.evaluations < certified.evaluations


def test_the_linear_chain_has_its_exact_symmetry():
    """u -> s u maps (V, K) to (s V, K / sqrt(s)): KE / V^2 depends on K sqrt(V) only."""
    chain = make_chain(20, 1e-3, 1.0, bistable=False)
    for s in (0.1, 7.0):
        scaled = chain._replace(contact=ThreeHalves(chain.contact.K / math.sqrt(s)))
        a = rk45.integrate(chain, V0, 1e-10, 1e-13, 10**8, 45.0, new_watch(()))
        b = rk45.integrate(scaled, s * V0, 1e-10, 1e-13 * s, 10**8, 45.0, new_watch(()))
        assert b.speed / s == pytest.approx(a.speed, rel=1e-8)


def test_a_chaotic_task_is_flagged_and_a_well_conditioned_one_is_not(reference):
    V = 0.1 / V0
    neighbours = [
        kernel.ke_ratio(50, 0.0, 1 / 0.159, V * (1 + k * 1e-6), method="rk45", rtol=1e-9, atol=1e-12) for k in range(3)
    ]
    ratios = np.array([r.ke_ratio for r in neighbours])
    assert np.ptp(ratios) > 1e-3 * ratios.mean(), "the task is chaotic whatever the method"
    assert kernel.ke_ratio(50, 0.0, 1 / 0.159, V).chaotic
    calm = reference[3]
    assert not kernel.ke_ratio(**{name: calm[name] for name in PARAMETERS}).chaotic


@pytest.mark.slow
def test_compiled_and_plain_python_give_the_same_numbers():
    asked = {"N": 3, "zeta_T": 1e-2, "M_over_M0": 1.0, "V_over_V0": 0.5, "method": "rk45", "rtol": 1e-2, "atol": 1e-5}
    program = f"import dataclasses, kernel; print(dataclasses.astuple(kernel.ke_ratio(**{asked}, certify=False))[:5])"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    plain = subprocess.run(
        [sys.executable, "-P", "-c", program], env=environment, capture_output=True, text=True, check=True, timeout=120
    )
    compiled = astuple(kernel.ke_ratio(**asked, certify=False))[:5]
    assert literal_eval(plain.stdout) == pytest.approx(compiled, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("N", 1),
        ("N", 2.5),
        ("N", True),
        ("N", "20"),
        ("zeta_T", -1e-9),
        ("zeta_T", math.nan),
        ("zeta_T", None),
        ("M_over_M0", 0),
        ("M_over_M0", math.inf),
        ("V_over_V0", -1.0),
        ("accuracy", 0.0),
        ("accuracy", 0.2),
        ("accuracy", math.nan),
        ("rtol", 0.0),
        ("atol", -1.0),
        ("max_steps", 0),
    ],
)
def test_a_bad_argument_is_named_with_its_rule_and_value(name, value):
    method = {"method": "rk45"} if name in ("rtol", "atol") else {}
    with pytest.raises(ValueError, match=rf"^{name}: must be .*, got {value!r}$"):
        kernel.ke_ratio(**(GOOD | method | {name: value}))


def test_tolerances_beside_the_method_that_chooses_them_are_named_with_their_values():
    with pytest.raises(ValueError, match=r"^rtol: stands only with method = .*, got 0\.001$"):
        kernel.ke_ratio(10, 1e-3, 1, 1, rtol=1e-3)
    with pytest.raises(ValueError, match=r"rtol: stands only .*, got 0\.001; atol: stands only .*, got 1e-06$"):
        kernel.ke_ratio(10, 1e-3, 1, 1, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("task", [(20, 1e-3, 1, 1), (150, 1e-5, 0.1622, 10), (20, 0.5, 1, 1)])
def test_beside_a_relative_tolerance_of_the_users_own_the_wanted_accuracy_does_not_count(task):
    found = {str(kernel.ke_ratio(*task, accuracy, "rk45", rtol=1e-4)) for accuracy in (1e-8, 1e-3, 1e-1)}
    assert len(found) == 1


def test_all_bad_arguments_are_named_at_once():
    with pytest.raises(ValueError, match=r"N: .*; zeta_T: .*; V_over_V0: "):
        kernel.ke_ratio(0, -1.0, 1.0, 0.0)
    with pytest.raises(ValueError, match=r"accuracy: .*; method: must be one of auto, rk45, got 'ode45'"):
        kernel.ke_ratio(**GOOD, accuracy=1.0, method="ode45")
    with pytest.raises(ValueError, match="rtol: stands only with"):
        kernel.ke_ratio(**GOOD, rtol=1e-3)


def test_numpy_numbers_are_numbers():
    task = dict(zip(PARAMETERS, (np.int32(10), np.float64(1e-3), np.float32(1), np.int64(1)), strict=True))
    assert kernel.ke_ratio(**task).ke_ratio == kernel.ke_ratio(**GOOD).ke_ratio


def test_a_run_that_does_not_finish_has_a_status_and_no_number():
    r = kernel.ke_ratio(**GOOD, max_steps=20)
    assert r.status == "step_budget"
    assert math.isnan(r.ke_ratio)
    assert not r.chaotic
