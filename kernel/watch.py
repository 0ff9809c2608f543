"""What is watched during a run: how fast the middle site ever was, and whatever else was asked for.

A run is divided into equal parts, and the largest speed of the middle site in each part is kept. If the largest of two
parts are nearly equal, a slightly different run may find the other one largest: then the answer is less sure.

A quantity (kernel.quantities) is one number of a run. Most are told by a value and its slope at the ends of all steps,
which are folded: into the largest magnitude over continuous time, unless the quantity has a fold of its own. The others
are told by the chain's last state. What is not asked for costs nothing: numba compiles a run for what is asked for.
"""

from inspect import signature
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from kernel.film import rewind
from kernel.jit import callable_of_an_empty_tuple, jit, unfused_jit
from kernel.maxima import cubic_crest
from kernel.model import Array, Chain

PARTS = 16  # of a run, equally long
# Of a quantity: value and slope at the last step's end, what they are folded into, when that was, what it keeps.
VALUE, SLOPE, FOUND, WHEN, KEPT = range(5)
# The first site whose quantities the steps of the splittings tell: nearer to the impact they change within a step.
# With 3, arrivals of 1500 random tasks at 1e-3 were off by up to 2.6e-2, 1.9e-3, 7.8e-4 at sites 3, 4, 5, accelerations
# by 1.9e-3, 1.6e-3, 9.6e-4 (python -m tests.quantities --random 1500 --seed 77 --sites 3).
TOLD_FROM = 5
FAR_BELOW = 0.5  # of the largest so far: what rises from below it within a step is largest at its end, by and large


class Watch(NamedTuple):
    """Asked for before a run, filled by it."""

    crests: Array  # (PARTS,): largest |v_mid| in each part of the run
    quantities: Any  # tuple of kernel.quantities
    memory: Array  # (quantities, 5): VALUE, SLOPE, FOUND, WHEN, KEPT of each
    film: Any  # kernel.film.Film of a scene; None: nobody looks at the whole chain


@jit
def new_watch(quantities: Any) -> Watch:
    """Nothing seen yet."""
    return Watch(np.zeros(PARTS), quantities, np.zeros((len(quantities), KEPT + 1)), None)


@jit
def blind_watch(quantities: Any) -> Watch:
    """For a run that is asked for the middle site alone: quantities keep no memory, and are not looked at."""
    return Watch(np.zeros(PARTS), quantities, np.zeros((0, KEPT + 1)), None)


@jit
def forget(watch: Watch) -> None:
    """Begin again."""
    watch.crests[:] = 0.0
    watch.memory[:] = 0.0
    rewind(watch.film)


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


@callable_of_an_empty_tuple
def fold(quantity: Any, memory: Array, t: float, h: float, now: float, rate: float) -> None:
    """Take in a step from t to t + h, at whose end the quantity has this value and slope."""
    quantity.fold(memory, t, h, now, rate)


@callable_of_an_empty_tuple
def kept(quantity: Any, chain: Chain, V: float) -> float:
    """What a quantity with a fold of its own asks to keep, before a run."""
    return float(quantity.kept(chain, V))


@callable_of_an_empty_tuple
def at_end(quantity: Any, chain: Chain, view: Any, kept: float) -> float:
    """Of a quantity that the last state tells; kept: what it asked to keep, else 0."""
    return float(quantity.at_end(chain, view, kept))


def has(quantity: Any, method: str) -> bool:
    """Whether a quantity has a method that not all have; known as the code is compiled."""
    return hasattr(quantity, method)


def is_folded(quantity: Any, view: Any) -> bool:
    """Whether a quantity is told by the ends of steps: not by the last state, nor, as pushes are, by `take_push`."""
    return not has(quantity, "at_end") and not (has(quantity, "is_push") and has(view, "tells_push"))


@callable_of_an_empty_tuple
def is_known(quantity: Any, memory: Array) -> bool:
    """Whether a quantity with a fold of its own need not be looked at any more."""
    return bool(quantity.is_known(memory))


@jit
def _never(quantity: Any, memory: Array) -> bool:
    return False


@jit
def is_far_below(memory: Array, now: float) -> bool:
    """Whether no crest is near that could be the largest: then the slope, which takes longer, is not asked for.

    The slope then counts as 0: of the two steps that meet here only the values at their ends are looked at.
    """
    return not abs(now) > FAR_BELOW * memory[FOUND]


@jit
def keep_largest(memory: Array, t: float, h: float, now: float, rate: float) -> None:
    """The largest magnitude within a step is that of the cubic through the values and slopes at its ends."""
    largest, where = cubic_crest(h, memory[VALUE], now, memory[SLOPE], rate)
    if largest > memory[FOUND]:
        memory[FOUND], memory[WHEN] = largest, t + where * h


@unfused_jit
def divide_one(quantity: Any, chain: Chain, V: float, own: Array) -> None:
    """The number of a quantity, (1,), by its scale."""
    own[0] /= scale(quantity, chain, V)


def begin_one(quantity: Any, chain: Chain, V: float, memory: Array) -> None:
    """Before a run at speed V."""
    if has(quantity, "kept"):
        memory[KEPT] = quantity.kept(chain, V)


def look_once(quantity: Any, chain: Chain, view: Any, t: float, h: float, memory: Array) -> None:
    """At the end of a step."""
    if not is_folded(quantity, view) or (has(quantity, "is_known") and quantity.is_known(memory)):
        return
    now, rate = quantity.value(chain, view), 0.0
    if has(quantity, "fold"):
        rate = quantity.slope(chain, view)
        quantity.fold(memory, t, h, now, rate)
    else:
        if not is_far_below(memory, now):
            rate = quantity.slope(chain, view)
        keep_largest(memory, t, h, now, rate)
    memory[VALUE], memory[SLOPE] = now, rate


def look_last(quantity: Any, chain: Chain, view: Any, t: float, memory: Array) -> None:
    """At the end of a run."""
    if has(quantity, "at_end"):
        memory[FOUND], memory[WHEN] = quantity.at_end(chain, view, memory[KEPT]), t


def take_push_once(quantity: Any, push: float, t: float, memory: Array) -> None:
    """Of a step that began at t, of which the integrator tells the largest push."""
    if has(quantity, "is_push") and push > memory[FOUND]:
        memory[FOUND], memory[WHEN] = push, t


def _kind(quantity: Any) -> Any:
    """The class of a quantity, told by its type; numba takes a tuple without fields for none."""
    return getattr(quantity, "instance_class", None)


@overload(begin_one)
def _compiled_begin(quantity, chain, V, memory):  # type: ignore[no-untyped-def]
    if not has(_kind(quantity), "kept"):
        return lambda quantity, chain, V, memory: None

    def found(quantity, chain, V, memory):  # type: ignore[no-untyped-def]
        memory[KEPT] = kept(quantity, chain, V)

    return found


@overload(look_once)
def _compiled_look_once(quantity, chain, view, t, h, memory):  # type: ignore[no-untyped-def]
    if not is_folded(_kind(quantity), _kind(view)):
        return lambda quantity, chain, view, t, h, memory: None
    is_over = is_known if has(_kind(quantity), "is_known") else _never

    def folded(quantity, chain, view, t, h, memory):  # type: ignore[no-untyped-def]
        if is_over(quantity, memory):
            return
        now, rate = value(quantity, chain, view), slope(quantity, chain, view)
        fold(quantity, memory, t, h, now, rate)
        memory[VALUE], memory[SLOPE] = now, rate

    def largest(quantity, chain, view, t, h, memory):  # type: ignore[no-untyped-def]
        now, rate = value(quantity, chain, view), 0.0
        if not is_far_below(memory, now):
            rate = slope(quantity, chain, view)
        keep_largest(memory, t, h, now, rate)
        memory[VALUE], memory[SLOPE] = now, rate

    return folded if has(_kind(quantity), "fold") else largest


@overload(take_push_once)
def _compiled_take_push_once(quantity, push, t, memory):  # type: ignore[no-untyped-def]
    if not has(_kind(quantity), "is_push"):
        return lambda quantity, push, t, memory: None

    def found(quantity, push, t, memory):  # type: ignore[no-untyped-def]
        if push > memory[FOUND]:
            memory[FOUND], memory[WHEN] = push, t

    return found


@overload(look_last)
def _compiled_look_last(quantity, chain, view, t, memory):  # type: ignore[no-untyped-def]
    if not has(_kind(quantity), "at_end"):
        return lambda quantity, chain, view, t, memory: None

    def found(quantity, chain, view, t, memory):  # type: ignore[no-untyped-def]
        memory[FOUND], memory[WHEN] = at_end(quantity, chain, view, memory[KEPT]), t

    return found


@jit
def largest_of(watch: Watch, chain: Chain, V: float) -> Array:
    """(quantities,): the number of each after a run, over its scale."""
    found = watch.memory[:, FOUND : FOUND + 1].copy()
    divide(watch.quantities, chain, V, found)
    return found.ravel()


def divide(quantities: Any, chain: Chain, V: float, found: Array) -> None:
    """Each by its scale; nothing where none was looked at, as in what follows."""
    for quantity, own in zip(quantities, found, strict=False):
        divide_one(quantity, chain, V, own)


def begin(quantities: Any, chain: Chain, V: float, memory: Array) -> None:
    """Before a run at speed V."""
    for quantity, own in zip(quantities, memory, strict=False):
        begin_one(quantity, chain, V, own)


def look(quantities: Any, chain: Chain, view: Any, t: float, h: float, memory: Array) -> None:
    """Look at the chain at the end of a step from t to t + h; view: its state, as kernel.quantities.View."""
    for quantity, own in zip(quantities, memory, strict=False):
        look_once(quantity, chain, view, t, h, own)


def look_at_end(quantities: Any, chain: Chain, view: Any, t: float, memory: Array) -> None:
    """Look at the chain at the end of the run."""
    for quantity, own in zip(quantities, memory, strict=False):
        look_last(quantity, chain, view, t, own)


def asks_for_push(quantities: Any) -> bool:
    """Whether one of them is the contact's largest push, which is over within one step of the chain."""
    return any(has(quantity, "is_push") for quantity in quantities)


def told_by_splittings(chain: Chain, quantities: Any) -> bool:
    """Whether their steps tell all of these: of the first sites they do not, nor where the push enters."""
    return chain.site >= TOLD_FROM and not any(has(quantity, "sees_impactor") for quantity in quantities)


def take_push(quantities: Any, push: float, t: float, memory: Array) -> None:
    """The largest push within a step that began at t."""
    for quantity, own in zip(quantities, memory, strict=False):
        take_push_once(quantity, push, t, own)


@overload(asks_for_push)
def _compiled_asks_for_push(quantities):  # type: ignore[no-untyped-def]
    asks = any(has(_kind(kind), "is_push") for kind in getattr(quantities, "types", ()))
    return (lambda quantities: True) if asks else (lambda quantities: False)


@overload(told_by_splittings)
def _compiled_told_by_splittings(chain, quantities):  # type: ignore[no-untyped-def]
    if any(has(_kind(kind), "sees_impactor") for kind in getattr(quantities, "types", ())):
        return lambda chain, quantities: False
    return lambda chain, quantities: chain.site >= TOLD_FROM


def _compile_line_by_line(every: Any, one: Any) -> None:
    """Compile the loop `every` over quantities as one call of `one` after the other: each has a type of its own.

    The first parameter of `every` are the quantities, the last an array with a row for each; where it has no rows,
    nothing is done. One function calls all: were each to call the next, each would be compiled with all that follow.
    """
    names = list(signature(every).parameters)
    rows = names[-1]

    def compiled(quantities: Any, *_: Any) -> Any:
        given, found = ", ".join(names[1:-1]), dict[str, Any]()
        calls = [f"        one(quantities[{k}], {given}, {rows}[{k}])\n" for k in range(len(quantities))]
        source = f"def compiled({', '.join(names)}):\n    if len({rows}) > 0:\n{''.join(calls)}        return\n"
        exec(source, {"one": one, "__name__": __name__}, found)
        return found["compiled"]

    compiled.__signature__ = signature(every)  # type: ignore[attr-defined]
    overload(every, strict=False)(compiled)


_compile_line_by_line(divide, divide_one)
_compile_line_by_line(begin, begin_one)
_compile_line_by_line(look, look_once)
_compile_line_by_line(take_push, take_push_once)
_compile_line_by_line(look_at_end, look_last)
