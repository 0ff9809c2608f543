"""Numbers too small for the normal format count as zero: ahead of a wave front they cost ten times a number."""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types

from kernel.jit import jit
from kernel.simd import compiled_as

FLUSH = 0x8040  # the two bits of x86's MXCSR that make subnormals zero, as input and as result
_I32 = ir.IntType(32)


@compiled_as(lambda word: -1)
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
    """Treat subnormals as zero in this thread.

    Returns what `restore_subnormals` needs; the caller must call it before it returns to Python.
    """
    return _control_word(np.int32(-1))


@jit
def restore_subnormals(word: int) -> None:
    """Undo flush_subnormals."""
    if word >= 0:
        _control_word(np.int32(word))
