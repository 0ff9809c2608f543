"""The one place that knows numba's flags."""

import gc
import inspect
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, TypeVar, cast

from llvmlite.binding import ffi
from numba import extending
from numba.core import config, event, types

from kernel.parts import Compiled

# While it compiles, numba calls LLVM half a million times, and tells of each to whoever measures how long LLVM takes:
# nobody here. That was a twelfth of the time.
ffi.lib._lock._cblist.clear()

# As it loads, numba asks for SciPy's BLAS, for products of matrices that the kernel does not have. To find none is safe
# (numba then multiplies by itself) and saves a quarter of a second at every start.
_BLAS = "scipy.linalg.cython_blas"
if _BLAS not in sys.modules:
    sys.modules[_BLAS] = None  # type: ignore[assignment]
    import numba.np.arraymath  # noqa: F401

    del sys.modules[_BLAS]


class _Compiled(event.Listener):
    """Counts the functions that numba compiles; what comes from the cache is none of them."""

    def __init__(self, tell: Callable[[int], None]) -> None:
        self.count, self.began, self.tell = 0, False, tell

    def on_start(self, event: Any) -> None:
        if not self.began:
            self.began = True
            self.tell(0)

    def on_end(self, event: Any) -> None:
        self.count += 1
        self.tell(self.count)


class _WithoutCollecting(event.Listener):
    """Lets Python's garbage collector rest while numba compiles: its searches took a fifth of that time."""

    def __init__(self) -> None:
        self._depth, self._was_on = 0, False

    def on_start(self, event: Any) -> None:
        if not self._depth:
            self._was_on = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        self._depth -= 1
        if not self._depth and self._was_on:
            gc.enable()


event.register("numba:compile", _WithoutCollecting())  # type: ignore[no-untyped-call]


def compiling(tell: Callable[[int], None]) -> AbstractContextManager[Any]:
    """Within it `tell` is called when compiling begins, with 0, and after each function, with their number."""
    told: AbstractContextManager[Any] = event.install_listener("numba:compile", _Compiled(tell))
    return told


F = TypeVar("F", bound=Callable[..., Any])
C = TypeVar("C", bound=type)

# Each relaxation by name; never fastmath=True, whose nnan and ninf delete the tests that catch a blow-up.
# contract: fused multiply-add. nsz: -0 equals +0 here. arcp: division by a constant becomes a product.
FASTMATH = {"contract", "nsz", "arcp"}


def _compile(function: F, fastmath: set[str], outer: bool = False, **how: Any) -> F:
    if vars(config)["DISABLE_JIT"]:
        return function
    options = {"nopython": True, "nogil": True, "error_model": "numpy", "fastmath": fastmath, "no_cfunc_wrapper": True}
    return cast(F, Compiled(function, options | how, outer))


def jit(function: F) -> F:
    """Compile `function`; it must not touch Python objects, so the GIL is released while it runs.

    One whose name begins with an underscore can be called by compiled functions only.
    """
    return _compile(function, FASTMATH)


def outer(function: F) -> F:
    """Compile a function that calls many others and does little itself, which shortens compiling.

    The compiler optimises it alone first, and together with all that it calls only at the end. A function with loops
    would become slower: the integrators would lose a sixth of their speed.
    """
    return _compile(function, FASTMATH, outer=True)


def inlined(function: F) -> F:
    """Compile a short function as a part of each of its callers: a call would take longer than what it does."""
    return _compile(function, FASTMATH, forceinline=True)


def written_out(function: F) -> F:
    """Copy a function into its callers before these are compiled: one that calls many and is called by few.

    Compiled by itself it would be linked with all that it calls, and all that would be optimised once more.
    """
    return _compile(function, FASTMATH, inline="always")


def unfused_jit(function: F) -> F:
    """Compile without fused multiply-adds a function that takes little time but whose last bits count.

    A callee is compiled again with each of its callers, where other operations may be fused, and which copy runs
    depends on what came from the cache: results of a first and of a second run could differ.
    """
    return _compile(function, {"nsz"})


def callable_in_compiled_code(face: C) -> C:
    """Let compiled code call the methods that `face` names on every named tuple that has them.

    numba knows a named tuple's fields, not its methods. Each method is compiled for the class at hand.
    """
    for name, method in vars(face).items():
        if not name.startswith("_") and name not in _CALLABLE:
            _CALLABLE.add(name)
            overload_method(types.BaseNamedTuple, name, strict=False, jit_options=_OPTIONS)(_found(name, method))
    return face


_CALLABLE: set[str] = set()
# Their stated types lack their options.
overload, overload_method = cast(Any, extending.overload), cast(Any, extending.overload_method)
_OPTIONS = {"no_cfunc_wrapper": True, "fastmath": FASTMATH, "error_model": "numpy", "nogil": True}


def callable_of_an_empty_tuple(function: F) -> F:
    """The same for one method of a named tuple without fields, which numba takes for none: `function` calls it.

    Named as the method, it has the tuple as its first parameter.
    """
    overload(function, strict=False, jit_options=_OPTIONS)(_found(function.__name__, function))
    return function


def either(of_none: F, of_another: F) -> Callable[[Any], F]:
    """What gives the first function for None and the second for anything else: only that is compiled.

    Of the branches of `if x is None` numba drops one where x is None; where x is something else it compiles both.
    """

    def chosen(x: Any) -> F:
        return of_none if x is None else of_another

    def found(x: Any) -> Any:
        function = chosen(None if isinstance(x, types.NoneType) else x)
        return lambda x: function

    overload(chosen, strict=False, inline="always")(found)
    return chosen


def _found(name: str, method: Callable[..., Any]) -> Callable[..., Any]:
    """What numba asks for the method's source, given the type; its parameters are those that the face states."""

    def found(self: Any, *_: Any) -> Any:
        return getattr(getattr(self, "instance_class", None), name, None)

    found.__signature__ = inspect.signature(method)  # type: ignore[attr-defined]
    return found
