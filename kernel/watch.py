"""What is watched during a run: how fast the middle site ever was, and whatever else was asked for.

Of the middle site the largest speed in each part of the run is kept: an answer is no surer than the second highest
crest allows, as another run may take a late, chaotic one that comes close to the peak for the peak.

Of a quantity (kernel.quantities) the largest magnitude over continuous time is kept. What is not asked for costs
nothing: numba compiles a run for the quantities at hand.
"""

from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from kernel.jit import callable_of_an_empty_tuple, jit
from kernel.maxima import cubic_crest
from kernel.model import Array, Chain

PARTS = 16  # of a run, equally long
VALUE, SLOPE, LARGEST, WHEN = range(4)  # of a quantity at the last step's end, and the largest magnitude so far


class Watch(NamedTuple):
    """Asked for before a run, filled by it."""

    crests: Array  # (PARTS,): largest |v_mid| in each part of the run
    quantities: Any  # tuple of kernel.quantities
    memory: Array  # (quantities, 4): VALUE, SLOPE, LARGEST, WHEN of each


@jit
def new_watch(quantities: Any) -> Watch:
    """Nothing seen yet."""
    return Watch(np.zeros(PARTS), quantities, np.zeros((len(quantities), WHEN + 1)))


@jit
def forget(watch: Watch) -> None:
    """Begin again."""
    watch.crests[:] = 0.0
    watch.memory[:] = 0.0


@jit
def part_of(t: float, t_end: float) -> int:
    """The part of the run in which t lies."""
    return min(PARTS - 1, int(t / t_end * PARTS))


@callable_of_an_empty_tuple
def value(quantity: Any, chain: Chain, view: Any) -> float:
    """Of a quantity at one time."""
    return float(quantity.value(chain, view))


@callable_of_an_empty_tuple
def slope(quantity: Any, chain: Chain, view: Any) -> float:
    """Its derivative by time."""
    return float(quantity.slope(chain, view))


@callable_of_an_empty_tuple
def scale(quantity: Any, chain: Chain, V: float) -> float:
    """What one unit of it is."""
    return float(quantity.scale(chain, V))


@jit
def _look(quantity: Any, chain: Chain, view: Any, t: float, h: float, memory: Array) -> None:
    """The largest magnitude within a step is that of the cubic through the values and slopes at its ends."""
    now, rate = value(quantity, chain, view), slope(quantity, chain, view)
    largest, where = cubic_crest(h, memory[VALUE], now, memory[SLOPE], rate)
    if largest > memory[LARGEST]:
        memory[LARGEST], memory[WHEN] = largest, t + where * h
    memory[VALUE], memory[SLOPE] = now, rate


@jit
def largest_of(watch: Watch, chain: Chain, V: float) -> Array:
    """(quantities,): the largest magnitude of each, over its scale."""
    largest = watch.memory[:, LARGEST].copy()
    _divide(watch.quantities, chain, V, largest)
    return largest


def _divide(quantities: Any, chain: Chain, V: float, largest: Array) -> None:
    for k, quantity in enumerate(quantities):
        largest[k] /= quantity.scale(chain, V)


def look(quantities: Any, chain: Chain, view: Any, t: float, h: float, memory: Array) -> None:
    """Look at the chain at the end of a step from t to t + h; view: its state, as kernel.quantities.View."""
    for k, quantity in enumerate(quantities):
        _look(quantity, chain, view, t, h, memory[k])


@overload(_divide)
def _compiled_divide(quantities, chain, V, largest):  # type: ignore[no-untyped-def]
    if len(quantities) == 0:
        return lambda quantities, chain, V, largest: None

    def one_after_the_other(quantities, chain, V, largest):  # type: ignore[no-untyped-def]
        largest[0] /= scale(quantities[0], chain, V)
        _divide(quantities[1:], chain, V, largest[1:])

    return one_after_the_other


@overload(look)
def _compiled_look(quantities, chain, view, t, h, memory):  # type: ignore[no-untyped-def]
    """Each quantity has a type of its own, so that the loop is written out, one call after the other."""
    if len(quantities) == 0:
        return lambda quantities, chain, view, t, h, memory: None

    def one_after_the_other(quantities, chain, view, t, h, memory):  # type: ignore[no-untyped-def]
        _look(quantities[0], chain, view, t, h, memory[0])
        look(quantities[1:], chain, view, t, h, memory[1:])

    return one_after_the_other
