"""Interpolation at equally spaced nodes: the coefficients, exact before they are rounded.

A numerical inverse of the Vandermonde matrix loses up to six digits here, and not the same ones on every machine.
"""

from fractions import Fraction

import numpy as np

from kernel.model import Array


def _times(a: list[Fraction], root: Fraction, scale: Fraction) -> list[Fraction]:
    """The polynomial a, lowest power first, times (x - root) * scale."""
    return [(low - root * high) * scale for low, high in zip([Fraction(0), *a], [*a, Fraction(0)], strict=True)]


def monomials(first: int, last: int, unit: int) -> Array:
    """(n, n): [power, node] coefficients of the polynomial through samples at k/unit, k = first .. last."""
    nodes = [Fraction(k, unit) for k in range(first, last + 1)]
    columns = []
    for node in nodes:
        cardinal = [Fraction(1)]  # Lagrange: one at its node, zero at the others
        for other in nodes:
            if other != node:
                cardinal = _times(cardinal, other, 1 / (node - other))
        columns.append([float(c) for c in cardinal])
    return np.ascontiguousarray(np.array(columns).T)
