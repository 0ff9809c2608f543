"""Coefficient algebra of Dormand-Prince 5(4)."""

import numpy as np
import pytest

from kernel.tableau import A_A, E_A, INTERPOLANT, STAGES, A, C, E

B = A[-1]  # weights of the solution
B4 = B - E  # weights of the embedded fourth-order solution


def conditions(b):
    """(order, value, what it must be) of every rooted tree up to order 5."""
    Ac, Ac2 = A @ C, A @ C**2
    return [
        (1, b.sum(), 1),
        (2, b @ C, 1 / 2),
        (3, b @ C**2, 1 / 3),
        (3, b @ Ac, 1 / 6),
        (4, b @ C**3, 1 / 4),
        (4, b @ (C * Ac), 1 / 8),
        (4, b @ Ac2, 1 / 12),
        (4, b @ A @ Ac, 1 / 24),
        (5, b @ C**4, 1 / 5),
        (5, b @ (C**2 * Ac), 1 / 10),
        (5, b @ (C * Ac2), 1 / 15),
        (5, b @ (C * (A @ Ac)), 1 / 30),
        (5, b @ Ac**2, 1 / 20),
        (5, b @ A @ C**3, 1 / 20),
        (5, b @ A @ (C * Ac), 1 / 40),
        (5, b @ A @ Ac2, 1 / 60),
        (5, b @ A @ A @ Ac, 1 / 120),
    ]


def test_the_solution_fulfils_every_condition_up_to_order_5():
    for _, value, wanted in conditions(B):
        assert value == pytest.approx(wanted, rel=1e-13)


def test_the_embedded_solution_has_order_4_and_not_5():
    fulfilled = {
        order: all(abs(value - wanted) < 1e-13 for o, value, wanted in conditions(B4) if o == order)
        for order in range(1, 6)
    }
    assert fulfilled == {1: True, 2: True, 3: True, 4: True, 5: False}


def test_stages_are_consistent_and_the_last_one_is_the_solution():
    np.testing.assert_allclose(A.sum(axis=1), C, rtol=0, atol=1e-14)
    assert STAGES == len(C) == 7
    assert C[-1] == 1
    assert np.all(np.triu(A) == 0)


def test_the_continuous_extension_ends_at_the_solution_with_the_right_slopes():
    powers = np.arange(1, 5)
    np.testing.assert_allclose(INTERPOLANT.sum(axis=1), B, atol=1e-14)
    slope_at_0, slope_at_1 = INTERPOLANT[:, 0], INTERPOLANT @ powers
    np.testing.assert_allclose(slope_at_0, np.eye(7)[0], atol=1e-14)
    np.testing.assert_allclose(slope_at_1, np.eye(7)[6], atol=1e-14)


def test_displacement_weights_follow_from_the_velocity_weights():
    np.testing.assert_allclose(A_A, A @ A)
    np.testing.assert_allclose(E_A, E @ A)
