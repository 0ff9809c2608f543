"""Arrays for the loops of integrators: numba counts who uses an array, and what is lent here it does not count."""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types

from kernel.jit import jit
from kernel.simd import compiled_as


@compiled_as(lambda owner: owner)
def borrowed(typing: Any, owner: Any) -> Any:
    """The array, or the tuple of arrays, but nobody counts who uses it: the owner is held until `give_back`.

    An array that is taken from a tuple or passed on is counted as a reference, atomically: a dozen times in a step of
    a chain, which took as long as the step itself.
    """

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _borrow(context, builder, sig.args[0], args[0])

    return owner(owner), lower


def _borrow(context: Any, builder: Any, kind: Any, x: Any) -> Any:
    if isinstance(kind, types.BaseTuple):
        own = enumerate(iter(kind))  # type: ignore[call-overload]
        parts = [_borrow(context, builder, part, builder.extract_value(x, k)) for k, part in own]
        return context.make_tuple(builder, kind, parts)
    if not isinstance(kind, types.Array):
        return x
    array = context.make_array(kind)(context, builder, x)
    array.meminfo, array.parent = (context.get_constant_null(of) for of in (types.voidptr, types.pyobject))
    return array._getvalue()


@compiled_as(lambda array: array)
def address_of(typing: Any, array: Any) -> Any:
    """Where the numbers of an array are, for `number_at` and `whole_at`: to look at single ones costs nothing else."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return context.make_array(sig.args[0])(context, builder, args[0]).data

    return types.CPointer(array.dtype)(array), lower


def _reader(kind: Any) -> Callable[..., Any]:
    def read(typing: Any, address: Any, i: Any) -> Any:
        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            x = builder.load(builder.gep(args[0], [args[1]]))
            return builder.fpext(x, ir.DoubleType()) if address.dtype == types.float32 else x

        return kind(address, types.intp), lower

    return read


def _entry(address: Any, i: int) -> Any:
    return address[i]


number_at = compiled_as(_entry)(_reader(types.float64))  # the number at i, as a double; no bounds check
whole_at = compiled_as(_entry)(_reader(types.int64))  # the same of whole numbers


@jit
def give_back(owner: Any) -> None:
    """Nobody uses what was borrowed of this array, or of those of this tuple, any more."""
