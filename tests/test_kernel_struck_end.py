"""Links push the struck end onto a heavy impactor again and again: their contacts add no energy to the chain."""

from functools import cache

import pytest

from kernel import Bistable, Hertz, Model, ke_ratio

CASES = {
    (21, 0.0029519, 32.555, 4.8974): Model(contact=Hertz(1.9138e8), site=1e-4),
    (4, 0.029787, 44.638, 3.0864): Model(contact=Hertz(2.992e9), site=0.2, t_end=4.732),
    (33, 0.0011696, 22.763, 15.884): Model(
        spring=Bistable(0.3624, 0.10857), contact=Hertz(5.13e11), site=1e-4, t_end=4.4913
    ),
    (2, 0.089834, 79.56, 1.0057): Model(t_end=2.94105),
    (5, 0.0106435, 51.759, 18.1418): Model(site=1e-4, t_end=3.63),
}


@cache
def by_dormand_prince(task):
    return ke_ratio(*task, method="rk45", rtol=1e-9, atol=1e-13, certify=False, model=CASES[task])


@pytest.mark.parametrize("accuracy", [0.1, 0.01, 0.001])
@pytest.mark.parametrize("task", CASES, ids=str)
def test_peaks_are_those_of_dormand_prince(task, accuracy):
    one, other = ke_ratio(*task, accuracy, certify=False, model=CASES[task]), by_dormand_prince(task)
    assert one.method == "explicit"
    assert one.ke_linear == pytest.approx(other.ke_linear, rel=accuracy)
    assert one.ke_bistable == pytest.approx(other.ke_bistable, rel=accuracy)


@pytest.mark.parametrize("task", CASES, ids=str)
def test_what_no_disturbance_moves_is_not_called_chaotic(task):
    certified = ke_ratio(*task, 0.01, model=CASES[task])
    assert certified.status == "done" and not certified.chaotic
    assert certified.ke_ratio == pytest.approx(by_dormand_prince(task).ke_ratio, rel=0.01)
