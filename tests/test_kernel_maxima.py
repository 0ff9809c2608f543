"""The maximum of a quartic over continuous time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kernel.maxima import peak_of_quartic

quartics = arrays(np.float64, 5, elements=st.floats(-10, 10, allow_subnormal=False))
X = np.linspace(0.0, 1.0, 4001)


@given(quartics)
def test_the_peak_is_the_maximum_of_the_densely_sampled_quartic(p):
    best, at = peak_of_quartic(p, 0.0)
    sampled = np.max(np.abs(np.polynomial.polynomial.polyval(X, p)))
    assert best >= sampled - 1e-12 * (1 + sampled)
    assert best <= sampled + 1e-5 * (1 + np.abs(p).sum())  # curvature times the sampling distance squared
    if best > 0:
        assert 0.0 <= at <= 1.0
        assert abs(np.polynomial.polynomial.polyval(at, p)) == pytest.approx(best, rel=1e-13, abs=1e-13)


@given(quartics, st.floats(0, 50))
def test_a_peak_is_only_replaced_by_a_higher_one(p, before):
    best, at = peak_of_quartic(p, before)
    assert best >= before
    assert (at == -1.0) == (best == before)


def test_a_peak_between_the_ends_of_a_step_is_found():
    """x (1 - x) is zero at both ends: a sampled maximum would miss all of it."""
    best, at = peak_of_quartic(np.array([0.0, 1.0, -1.0, 0.0, 0.0]), 0.0)
    assert (best, at) == (0.25, 0.5)
