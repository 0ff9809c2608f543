"""Machine code for what Python calls only: everything else is compiled as a part, which its callers are linked with.

numba makes machine code of every function, then again of each caller with the function inside it, and so on outwards,
although only the outermost is ever called. That was two fifths of the time that the kernel took to compile. The bits
of all results are the same either way.
"""

import itertools
import os
from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any

from llvmlite import binding
from numba.core.bytecode import FunctionIdentity
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

from kernel.cache import kept

# By counting numba tells functions of one name apart. Where processes find what others kept, no two may count alike.
FunctionIdentity._unique_ids = itertools.count(int.from_bytes(os.urandom(6)))


class _Part(JITCodeLibrary):
    """Optimised code of a function, and of what it calls, that waits for its callers."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True
        self._get_module_for_linking()
        # Machine code is made of nothing but the place where numba writes down the function's environment.
        places = [place.name for place in self._final_module.global_variables if place.name.startswith("_ZN08NumbaEnv")]
        self._final_module = binding.parse_assembly("\n".join(f"@{name} = common global i64 0" for name in places))
        super()._finalize_final_module()


class _OuterPart(_Part):
    """The same, optimised before it is linked with what it calls."""

    def finalize(self) -> None:
        super()._optimize_final_module()
        super().finalize()

    def _optimize_final_module(self) -> None:
        pass


class _PartCompiler(Compiler):
    library = _Part

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.state.library = self.library(self.state.targetctx.codegen(), "part")
        self.state.library.enable_object_caching()


class _OuterPartCompiler(_PartCompiler):
    library = _OuterPart


class Compiled:
    """A function for Python, and its part for compiled callers; of one whose name begins with an underscore only that.

    Both are made when they are asked for: a process that finds its outermost functions compiled needs no part, and
    numba takes a third of a millisecond for each.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any], outer: bool) -> None:
        self.py_func, self.targetoptions, self._outer = function, options, outer
        update_wrapper(self, function)

    @cached_property
    def called(self) -> Any:
        """The part; `outer`: optimised without what it calls, which is optimised already."""
        how, options = _OuterPartCompiler if self._outer else _PartCompiler, self.targetoptions
        made = CPUDispatcher(self.py_func, targetoptions=options | {"no_cpython_wrapper": True}, pipeline_class=how)
        return kept(made, ".part")

    @cached_property
    def from_python(self) -> Any:
        """What Python calls."""
        if self.py_func.__name__.startswith("_"):
            return self.called
        return kept(CPUDispatcher(self.py_func, targetoptions=self.targetoptions), "")

    @property
    def _numba_type_(self) -> Any:
        return self.called._numba_type_

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.from_python(*arguments, **named)

    def __reduce__(self) -> Any:
        return self.called.__reduce__()
