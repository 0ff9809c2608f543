"""Eight doubles or sixteen singles as one value: SIMD over the sites of one chain, whatever the loop vectoriser does.

LLVM fits the operations to what the processor has (zmm, ymm, xmm or scalars). Without the compiler
(NUMBA_DISABLE_JIT=1) the same functions work on numpy arrays of as many: the plain-Python twin.
"""

import operator
from collections.abc import Callable, Iterable
from functools import partial
from inspect import signature
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, config, types
from numba.extending import intrinsic, models, overload, register_model

from kernel.jit import jit

CACHE_LINE = 64  # bytes of a cache line, and of most packs
WIDTH, WIDEST = 8, 16  # doubles of a pack, and singles
_DOUBLE, _SINGLE, _I32 = ir.DoubleType(), ir.FloatType(), ir.IntType(32)
PLAIN: bool = vars(config)["DISABLE_JIT"]
SINGLE, DOUBLE = np.float32(1.0), np.float64(1.0)  # a one of either precision: arrays are made as precise as it is


class VectorType(types.Type):
    """numba's type of packed numbers."""

    def __init__(self, number: Any, number_in_llvm: Any, width: int) -> None:
        self.number, self.width, self.suffix = number, width, f"v{width}f{number.bitwidth}"
        self.in_llvm = ir.VectorType(number_in_llvm, width)
        super().__init__(name=f"Vector{self.suffix}")

    def constant(self, x: float) -> Any:
        """All of them equal to x, in LLVM's words."""
        return ir.Constant(self.in_llvm, [x] * self.width)

    def shuffled(self, builder: Any, a: Any, b: Any, places: Iterable[int]) -> Any:
        """Those at these places of a and, from `width` on, of b."""
        chosen = list(places)
        return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_I32, len(chosen)), chosen))


vector = VectorType(types.float64, _DOUBLE, WIDTH)
lines = VectorType(types.float64, _DOUBLE, WIDEST)  # two cache lines of doubles
singles = VectorType(types.float32, _SINGLE, WIDEST)
PACKS = {kind.number: kind for kind in (vector, singles)}  # one cache line of an array


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.in_llvm)


def compiled_as(twin: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Use the intrinsic in compiled code and `twin` where the compiler is off."""

    def choose(typing: Callable[..., Any]) -> Any:
        return twin if PLAIN else intrinsic(typing)

    return choose


def packed(twin: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """The same of a function that makes a pack of packs of its type by LLVM's builder."""

    def made(lower: Callable[..., Any]) -> Any:
        def typed(typing: Any, a: Any, *others: Any) -> Any:
            return a(a, *others), lambda context, builder, sig, args: lower(builder, a, *args)

        typed.__signature__ = signature(partial(lower, None))  # type: ignore[attr-defined] # where numba looks
        return compiled_as(twin)(typed)

    return made


def width(array: Any) -> int:
    """How many numbers of an array make a pack; known as the code is compiled."""
    return CACHE_LINE // int(array.itemsize)


@overload(width)
def _compiled_width(array):  # type: ignore[no-untyped-def]
    many = PACKS[array.dtype].width
    return lambda array: many


def _at(context: Any, builder: Any, kind: Any, array: Any, index: Any, packed: Any) -> Any:
    """Where a pack of this LLVM type lies in an array."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), packed.as_pointer())


def _loader(kind_of: Callable[[Any], VectorType]) -> Callable[..., Any]:
    def load(typing: Any, array: Any, i: Any) -> Any:
        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            where = _at(context, builder, sig.args[0], args[0], args[1], kind_of(array).in_llvm)
            return builder.load(where, align=array.dtype.bitwidth // 8)

        return kind_of(array)(array, types.intp), lower

    return load


# array[i : i + width(array)], and sixteen numbers from i on, of a contiguous array; no bounds check.
load = compiled_as(lambda array, i: array[i : i + width(array)].copy())(_loader(lambda array: PACKS[array.dtype]))
load_sixteen = compiled_as(lambda array, i: array[i : i + WIDEST].copy())(
    _loader(lambda array: lines if array.dtype == types.float64 else singles)
)


@compiled_as(lambda array, i, x: array.__setitem__(slice(i, i + len(x)), x))
def store(typing: Any, array: Any, i: Any, x: Any) -> Any:
    """Write x to array[i : i + len(x)]; no bounds check."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        where = _at(context, builder, sig.args[0], args[0], args[1], x.in_llvm)
        builder.store(args[2], where, align=array.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, x), lower


@compiled_as(lambda array, i: array[i : i + WIDTH].astype(np.float64))
def load_doubles(typing: Any, array: Any, i: Any) -> Any:
    """Eight doubles equal to array[i : i + 8], however precise it is; no bounds check."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.VectorType(PACKS[array.dtype].in_llvm.element, WIDTH)
        x = builder.load(_at(context, builder, sig.args[0], args[0], args[1], kind), align=array.dtype.bitwidth // 8)
        return builder.fpext(x, vector.in_llvm) if array.dtype == types.float32 else x

    return vector(array, types.intp), lower


@compiled_as(lambda x: np.full(WIDTH, x))
def splat(typing: Any, x: Any) -> Any:
    """Eight doubles equal to x."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _filled(builder, vector, args[0])

    return vector(types.float64), lower


@compiled_as(lambda x, like: np.full_like(like, x))
def splat_as(typing: Any, x: Any, like: Any) -> Any:
    """As many equal to x as the pack `like` holds, and as precise."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _filled(builder, like, args[0])

    return like(types.float64, like), lower


def _filled(builder: Any, kind: VectorType, x: Any) -> Any:
    x = builder.fptrunc(x, _SINGLE) if kind == singles else x
    undefined = ir.Constant(kind.in_llvm, ir.Undefined)
    one = builder.insert_element(undefined, x, ir.Constant(_I32, 0))
    return kind.shuffled(builder, one, undefined, [0] * kind.width)


@compiled_as(lambda a, i: a[i])
def element(typing: Any, a: Any, i: Any) -> Any:
    """a[i] as a double."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        x = builder.extract_element(args[0], builder.trunc(args[1], _I32))
        return builder.fpext(x, _DOUBLE) if a == singles else x

    return types.float64(a, types.intp), lower


def negative_part(a: Any) -> Any:
    """min(a, 0), nan staying nan: of a number, of packed ones, in plain Python of an array."""
    return np.minimum(a, 0.0)


@intrinsic
def _negative_part(typing: Any, a: Any) -> Any:
    kind, zero = (a, a.constant(0.0)) if isinstance(a, VectorType) else (types.float64, ir.Constant(_DOUBLE, 0.0))

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", args[0], zero), zero, args[0])

    return kind(kind), lower


@overload(negative_part)
def _compiled_negative_part(a):  # type: ignore[no-untyped-def]
    return lambda a: _negative_part(a)  # type: ignore[call-arg]


@packed(lambda a, b: np.where(a > b, a, b))
def larger(builder: Any, kind: VectorType, a: Any, b: Any) -> Any:
    """Element-wise maximum; b where one of them is nan."""
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


@packed(lambda a, b: np.where(a < b, a, b))
def smaller(builder: Any, kind: VectorType, a: Any, b: Any) -> Any:
    """Element-wise minimum; b where one of them is nan."""
    return builder.select(builder.fcmp_ordered("<", a, b), a, b)


def _reducer(name: str) -> Callable[..., Any]:
    def reduce(typing: Any, a: Any) -> Any:
        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            kind = ir.FunctionType(a.in_llvm.element, [a.in_llvm])
            found = cgutils.get_or_insert_function(builder.module, kind, f"llvm.vector.reduce.{name}.{a.suffix}")
            x = builder.call(found, args)
            return builder.fpext(x, _DOUBLE) if a == singles else x

        return types.float64(a), lower

    return reduce


least = compiled_as(np.fmin.reduce)(_reducer("fmin"))  # of one pack, as a double; nan only where all are
greatest = compiled_as(np.fmax.reduce)(_reducer("fmax"))


@packed(np.abs)
def magnitude(builder: Any, kind: VectorType, a: Any) -> Any:
    """Absolute value."""
    function = ir.FunctionType(kind.in_llvm, [kind.in_llvm])
    return builder.call(cgutils.get_or_insert_function(builder.module, function, f"llvm.fabs.{kind.suffix}"), [a])


@overload(abs)
def _compiled_abs(a):  # type: ignore[no-untyped-def]
    return (lambda a: magnitude(a)) if isinstance(a, VectorType) else None


@packed(lambda before, a: np.concatenate([before[-1:], a[:-1]]))
def left_neighbours(builder: Any, kind: VectorType, before: Any, a: Any) -> Any:
    """[before[-1], a[0], ..., a[-2]], `before` being the sites to the left of a."""
    return kind.shuffled(builder, before, a, range(kind.width - 1, 2 * kind.width - 1))


@packed(lambda a, after: np.concatenate([a[1:], after[:1]]))
def right_neighbours(builder: Any, kind: VectorType, a: Any, after: Any) -> Any:
    """[a[1], ..., a[-1], after[0]], `after` being the sites to the right of a."""
    return kind.shuffled(builder, a, after, range(1, kind.width + 1))


@compiled_as(lambda a: (a[:WIDTH], a[WIDTH:]))
def halved(typing: Any, a: Any) -> Any:
    """Sixteen numbers as two times eight doubles."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        parts = [a.shuffled(builder, args[0], args[0], range(k, k + WIDTH)) for k in (0, WIDTH)]
        if a == singles:
            parts = [builder.fpext(part, vector.in_llvm) for part in parts]
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(vector, 2)(a), lower


@compiled_as(lambda a, b, like: np.concatenate([a, b]))
def joined(typing: Any, a: Any, b: Any, like: Any) -> Any:
    """What was `halved`, as precise as `like`."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        parts = args[:2]
        if like == singles:
            parts = [builder.fptrunc(part, ir.VectorType(_SINGLE, WIDTH)) for part in parts]
        return like.shuffled(builder, parts[0], parts[1], range(WIDEST))

    return like(a, b, like), lower


def _arithmetic(operation: Any, instruction: str) -> None:
    """Let `operation` work on two packs, or on a pack and a double."""
    of_packs = packed(operation)(lambda builder, kind, a, b: getattr(builder, instruction)(a, b))

    # Without annotations: numba wants those of the implementations, lambdas, to be the same.
    @overload(operation)
    def typed(a, b):  # type: ignore[no-untyped-def]
        if isinstance(a, VectorType) and a == b:
            return lambda a, b: of_packs(a, b)
        if isinstance(a, VectorType) and isinstance(b, types.Float):
            return lambda a, b: of_packs(a, splat_as(b, a))
        if isinstance(b, VectorType) and isinstance(a, types.Float):
            return lambda a, b: of_packs(splat_as(a, b), b)
        return None


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _arithmetic(_operation, _instruction)


@jit
def zeros(n: int, one: Any = DOUBLE) -> np.ndarray:
    """n zeros, as precise as `one`, that begin at a cache line, so that packed loads do not straddle two."""
    raw = np.full(n + WIDEST, one - one)
    skip = (-(raw.ctypes.data // raw.itemsize)) % width(raw)
    return raw[skip : skip + n]
