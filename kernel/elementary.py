"""Exponential and power of eight packed numbers, or of one: what laws beyond polynomials are made of.

The mathematics library knows one number at a time; of eight it would take eight calls. Here all eight go through one
polynomial, right to some units in the last place. A single number, as in bounds and energies, goes to the library, and
sixteen are two times eight.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils
from numba.extending import overload

from kernel.jit import jit
from kernel.simd import VectorType, halved, joined, larger, negative_part, packed, smaller, splat, vector

_LOG2_E = 1.4426950408889634
_LN2_HIGH, _LN2_LOW = 0.693147180369123816490, 1.90821492927058770002e-10  # the first has 32 zero bits at its end
_MAGIC = 6755399441055744.0  # 1.5 * 2^52: added to a number it leaves its nearest whole number in the lowest bits
_EXPONENT_MAX = 700.0
_SMALLEST = 1e-300
_ROOT_HALF = 0x3FE6A09E667F3BCD  # the bits of 1/sqrt(2)
_GROWTH = tuple(1.0 / math.factorial(k) for k in range(2, 14))
_ARTANH = tuple(1.0 / (2 * k + 1) for k in range(1, 11))
_I64 = ir.VectorType(ir.IntType(64), 8)
_F64 = vector.in_llvm


def _whole(n: int) -> ir.Constant:
    return ir.Constant(_I64, [n] * 8)


@packed(np.exp2)
def _two_to(builder: Any, kind: VectorType, shifted: Any) -> Any:
    """2^k of eight k + _MAGIC, k whole."""
    k = builder.add(builder.bitcast(shifted, _I64), _whole(1023))
    return builder.bitcast(builder.shl(k, _whole(52)), _F64)


def _shifted(builder: Any, x: Any) -> Any:
    """The bits of x, which end at a power of two where x is 1/sqrt(2) times one."""
    return builder.add(builder.bitcast(x, _I64), _whole((1023 << 52) - _ROOT_HALF))


@packed(np.frexp)
def _mantissa(builder: Any, kind: VectorType, x: Any) -> Any:
    """The m from 1/sqrt(2) to sqrt(2) with x = m 2^k, of eight normal x above 0."""
    kept = builder.and_(_shifted(builder, x), _whole((1 << 52) - 1))
    return builder.bitcast(builder.add(kept, _whole(_ROOT_HALF)), _F64)


@packed(np.frexp)
def _exponent(builder: Any, kind: VectorType, x: Any) -> Any:
    """The k of `_mantissa`, as numbers."""
    k = builder.lshr(_shifted(builder, x), _whole(52))
    # The bits of 2^52 + k as a number: no conversion, which many processors have for one number only.
    shifted = builder.bitcast(builder.or_(k, _whole(0x4330000000000000)), _F64)
    return builder.fsub(shifted, vector.constant(4503599627370496.0 + 1023.0))


@packed(np.sqrt)
def _root(builder: Any, kind: VectorType, x: Any) -> Any:
    found = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_F64, [_F64]), "llvm.sqrt.v8f64")
    return builder.call(found, [x])


@jit
def _packed_exponential(x: Any) -> Any:
    """The s and p with e^x = s + s p, s a power of two; x beyond 700 either way as there, nan of nan."""
    x = smaller(splat(_EXPONENT_MAX), larger(splat(-_EXPONENT_MAX), x))
    shifted = x * _LOG2_E + _MAGIC
    k = shifted - _MAGIC
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    q = splat(_GROWTH[11])
    for i in range(10, -1, -1):
        q = q * r + _GROWTH[i]
    return _two_to(shifted), q * (r * r) + r


@jit
def _packed_growth(x: Any) -> Any:
    s, p = _packed_exponential(x)
    return s * p + (s - 1.0)


@jit
def _packed_power(x: Any, n: float) -> Any:
    if n == 1.5:
        return x * _root(x)
    x = larger(splat(_SMALLEST), x)
    m, k = _mantissa(x), _exponent(x)
    f = (m - 1.0) / (m + 1.0)  # log m = 2 artanh f
    square = f * f
    q = splat(_ARTANH[9])
    for i in range(8, -1, -1):
        q = q * square + _ARTANH[i]
    s, p = _packed_exponential(n * (k * _LN2_HIGH + (k * _LN2_LOW + 2.0 * (f * (square * q) + f))))
    return s * p + s + (x - x)  # the bits of nan are a number's


@jit
def _growth_of_sixteen(x: Any) -> Any:
    a, b = halved(x)
    return joined(_packed_growth(a), _packed_growth(b), x)


@jit
def _power_of_sixteen(x: Any, n: float) -> Any:
    a, b = halved(x)
    return joined(_packed_power(a, n), _packed_power(b, n), x)


@jit
def _packed_bend(x: Any, n: float) -> Any:
    return (_packed_power(-1.0 * negative_part(x - 1.0), n) - 1.0) + n * x


@jit
def _bend_of_sixteen(x: Any, n: float) -> Any:
    a, b = halved(x)  # what is small against 1 is told in double precision
    return joined(_packed_bend(a, n), _packed_bend(b, n), x)


def growth(x: Any) -> Any:
    """e^x - 1, of a number, of packed ones, in plain Python of an array."""
    return np.expm1(x)


def power(x: Any, n: float) -> Any:
    """x^n for x >= 0 and n > 0, of the same."""
    return np.power(x, n)


def bend_of_power(x: Any, n: float) -> Any:
    """(1 - x)^n - 1 + n x, the power 0 beyond x = 1, of the same: what a power's tangent at 1 leaves."""
    return np.power(np.maximum(1.0 - np.asarray(x, np.float64), 0.0), n) - 1.0 + n * x


def _suited(x: Any, *each: Callable[..., Any]) -> Callable[..., Any]:
    """What serves eight packed numbers, sixteen, or one, by the type of x."""
    return each[0] if x == vector else each[1] if isinstance(x, VectorType) else each[2]


@overload(growth)
def _compiled_growth(x):  # type: ignore[no-untyped-def]
    return _suited(x, lambda x: _packed_growth(x), lambda x: _growth_of_sixteen(x), lambda x: math.expm1(x))


@overload(power)
def _compiled_power(x, n):  # type: ignore[no-untyped-def]
    return _suited(
        x,
        lambda x, n: _packed_power(x, n),
        lambda x, n: _power_of_sixteen(x, n),
        lambda x, n: x * math.sqrt(x) if n == 1.5 else x**n,
    )


@overload(bend_of_power)
def _compiled_bend(x, n):  # type: ignore[no-untyped-def]
    return _suited(
        x,
        lambda x, n: _packed_bend(x, n),
        lambda x, n: _bend_of_sixteen(x, n),
        lambda x, n: max(1.0 - x, 0.0) ** n - 1.0 + n * x,
    )
