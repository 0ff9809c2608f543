"""Eight doubles as one value: SIMD over the sites of one chain that does not depend on the loop vectoriser.

LLVM fits the operations to what the processor has (zmm, ymm, xmm or scalars). Without the compiler
(NUMBA_DISABLE_JIT=1) the same functions work on numpy arrays of eight: the plain-Python twin.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, config, types
from numba.extending import intrinsic, models, overload, register_model

from kernel.jit import jit

WIDTH = 8
_DOUBLE, _I32, _I64 = ir.DoubleType(), ir.IntType(32), ir.IntType(64)
_VECTOR = ir.VectorType(_DOUBLE, WIDTH)
_MASK = ir.VectorType(_I32, WIDTH)
_ZERO = ir.Constant(_VECTOR, [0.0] * WIDTH)
_UNDEFINED = ir.Constant(_VECTOR, ir.Undefined)
PLAIN: bool = vars(config)["DISABLE_JIT"]
FLUSH = 0x8040  # the two bits of x86's MXCSR that make subnormals zero, as input and as result


class VectorType(types.Type):
    """numba's type of eight packed doubles."""

    def __init__(self) -> None:
        super().__init__(name="Vector8")


vector = VectorType()


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _compiled(twin: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Use the intrinsic in compiled code and `twin` where the compiler is off."""

    def choose(typing: Callable[..., Any]) -> Any:
        return twin if PLAIN else intrinsic(typing)

    return choose


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


@_compiled(lambda array, i: array[i : i + WIDTH].copy())
def load(typing: Any, array: Any, i: Any) -> Any:
    """array[i : i+8] of a contiguous array of doubles; no bounds check."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_address(context, builder, sig.args[0], args[0], args[1]), align=8)

    return vector(array, types.intp), lower


@_compiled(lambda array, i, x: array.__setitem__(slice(i, i + WIDTH), x))
def store(typing: Any, array: Any, i: Any, x: Any) -> Any:
    """array[i : i+8] = x; no bounds check."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[2], _address(context, builder, sig.args[0], args[0], args[1]), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, vector), lower


@_compiled(lambda array: array)
def borrowed(typing: Any, array: Any) -> Any:
    """Where the numbers of an array are, for `number_at` and `whole_at`, until it is used for the last time.

    An array in a tuple is counted as a reference, atomically, wherever it is taken from it: more work than to read one
    number of it. An array that would be let go earlier is held until `give_back`.
    """

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.ptrtoint(context.make_array(sig.args[0])(context, builder, args[0]).data, _I64)

    return types.int64(array), lower


def _reader(kind: Any, of: Any) -> Callable[..., Any]:
    def read(typing: Any, lent: Any, i: Any) -> Any:
        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return builder.load(builder.gep(builder.inttoptr(args[0], of.as_pointer()), [args[1]]))

        return kind(types.int64, types.intp), lower

    return read


def _entry(lent: Any, i: int) -> Any:
    return lent[i]


number_at = _compiled(_entry)(_reader(types.float64, _DOUBLE))  # of what is borrowed, the double at i; no bounds check
whole_at = _compiled(_entry)(_reader(types.int64, _I64))  # the same of whole numbers


@jit
def give_back(array: Any) -> None:
    """Nobody looks at what was borrowed of this array any more."""


@_compiled(lambda x: np.full(WIDTH, x))
def splat(typing: Any, x: Any) -> Any:
    """All eight equal to x."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        one = builder.insert_element(_UNDEFINED, args[0], ir.Constant(_I32, 0))
        return builder.shuffle_vector(one, _UNDEFINED, ir.Constant(_MASK, [0] * WIDTH))

    return vector(types.float64), lower


@_compiled(lambda a, i: a[i])
def element(typing: Any, a: Any, i: Any) -> Any:
    """a[i] as a double."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_element(args[0], builder.trunc(args[1], _I32))

    return types.float64(vector, types.intp), lower


def negative_part(a: Any) -> Any:
    """min(a, 0), nan staying nan: of a number, of eight packed ones, in plain Python of an array."""
    return np.minimum(a, 0.0)


@intrinsic
def _negative_part(typing: Any, a: Any) -> Any:
    kind, zero = (vector, _ZERO) if a == vector else (types.float64, ir.Constant(_DOUBLE, 0.0))

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", args[0], zero), zero, args[0])

    return kind(kind), lower


@overload(negative_part)
def _compiled_negative_part(a):  # type: ignore[no-untyped-def]
    return lambda a: _negative_part(a)  # type: ignore[call-arg]


@_compiled(lambda a, b: np.where(a > b, a, b))
def larger(typing: Any, a: Any, b: Any) -> Any:
    """Element-wise maximum; b where one of them is nan."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", args[0], args[1]), args[0], args[1])

    return vector(vector, vector), lower


@_compiled(lambda a, b: np.where(a < b, a, b))
def smaller(typing: Any, a: Any, b: Any) -> Any:
    """Element-wise minimum; b where one of them is nan."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered("<", args[0], args[1]), args[0], args[1])

    return vector(vector, vector), lower


@_compiled(np.abs)
def magnitude(typing: Any, a: Any) -> Any:
    """Absolute value."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(_VECTOR, [_VECTOR])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.fabs.v8f64"), args)

    return vector(vector), lower


@_compiled(lambda before, a: np.concatenate([before[-1:], a[:-1]]))
def left_neighbours(typing: Any, before: Any, a: Any) -> Any:
    """[before[7], a[0], ..., a[6]], `before` being the eight sites to the left of a."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.shuffle_vector(args[0], args[1], ir.Constant(_MASK, [WIDTH - 1 + k for k in range(WIDTH)]))

    return vector(vector, vector), lower


@_compiled(lambda a, after: np.concatenate([a[1:], after[:1]]))
def right_neighbours(typing: Any, a: Any, after: Any) -> Any:
    """[a[1], ..., a[7], after[0]], `after` being the eight sites to the right of a."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.shuffle_vector(args[0], args[1], ir.Constant(_MASK, [1 + k for k in range(WIDTH)]))

    return vector(vector, vector), lower


def _arithmetic(operation: Any, instruction: str) -> None:
    """Let `operation` work on two vectors, or on a vector and a double."""

    def signature(typing: Any, a: Any, b: Any) -> Any:
        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return getattr(builder, instruction)(args[0], args[1])

        return vector(vector, vector), lower

    packed: Any = intrinsic(signature)

    # Without annotations: numba wants those of the implementations, lambdas, to be the same.
    @overload(operation)
    def typed(a, b):  # type: ignore[no-untyped-def]
        if a == vector and b == vector:
            return lambda a, b: packed(a, b)
        if a == vector and isinstance(b, types.Float):
            return lambda a, b: packed(a, splat(b))
        if b == vector and isinstance(a, types.Float):
            return lambda a, b: packed(splat(a), b)
        return None


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _arithmetic(_operation, _instruction)


@_compiled(lambda word: -1)
def _control_word(typing: Any, word: Any) -> Any:
    """x86: load MXCSR with `word`, or add FLUSH to it where `word` is negative; what it was. Elsewhere -1."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if "x86" not in str(builder.module.triple):
            return ir.Constant(_I32, -1)
        slot = cgutils.alloca_once(builder, _I32)
        pointer = builder.bitcast(slot, ir.IntType(8).as_pointer())
        kind = ir.FunctionType(ir.VoidType(), [pointer.type])
        builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.sse.stmxcsr"), [pointer])
        before = builder.load(slot)
        flush = builder.icmp_signed("<", args[0], ir.Constant(_I32, 0))
        builder.store(builder.select(flush, builder.or_(before, ir.Constant(_I32, FLUSH)), args[0]), slot)
        builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.sse.ldmxcsr"), [pointer])
        return before

    return types.int32(types.int32), lower


@jit
def flush_subnormals() -> int:
    """Treat subnormals as zero in this thread, as ahead of a wave front they cost ten times a number.

    Returns what `restore_subnormals` needs; the caller must call it before it returns to Python.
    """
    return _control_word(np.int32(-1))


@jit
def restore_subnormals(word: int) -> None:
    """Undo flush_subnormals."""
    if word >= 0:
        _control_word(np.int32(word))


@jit
def zeros(n: int) -> np.ndarray:
    """n zeros that begin at a cache line, so that packed loads do not straddle two."""
    raw = np.zeros(n + WIDTH)
    skip = (-(raw.ctypes.data // 8)) % WIDTH
    return raw[skip : skip + n]
