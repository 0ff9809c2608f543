"""The kernel in two halves that take as long, for two processes that compile it together: what one keeps, both find."""

from collections.abc import Mapping
from typing import Any

from numba import typeof
from numba.core import types

from kernel import integrate
from kernel.lattice import Model
from kernel.method import EXPLICIT, choose
from kernel.model import lattice_chain, linear_chain
from kernel.watch import new_watch


def compile_half(second: bool, model: Model, quantities: Mapping[str, Any]) -> None:
    """Compile the fast methods, or, as the second half, Dormand-Prince: both for what `kernel.solve` asks of them.

    Where Dormand-Prince alone serves, the halves are the chain and its linear companion, if their types differ.
    model, quantities: as of `kernel.ke.results_of`. What differs from its types there costs time, and no more: who
    needs it compiles it.
    """
    lattice, real = typeof(model.lattice(model.sites or 2)), types.float64
    watch = _returned_by(new_watch, typeof(tuple(quantities.values())))
    chains = [_returned_by(make, types.int64, real, real, lattice) for make in (lattice_chain, linear_chain)]
    distinct = list(dict.fromkeys(chains))
    for chain in distinct if model.is_uniform else distinct[second::2]:
        if second or not model.is_uniform:
            _compile(integrate._by_dormand_prince, chain, real, real, typeof(choose()), watch)
        else:
            _compile(integrate.run_by, typeof(EXPLICIT), chain, real, real, real, types.int64, watch)


def _compile(function: Any, *arguments: Any) -> Any:
    """The part of other compiled functions that it is, for arguments of these types."""
    function.called.compile(arguments)
    return function.called


def _returned_by(function: Any, *arguments: Any) -> Any:
    """The type of what a compiled function gives for arguments of these types."""
    return _compile(function, *arguments).overloads[arguments].signature.return_type
