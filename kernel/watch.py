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


def _method(name: str, parameters: str) -> Any:
    """A function that calls this method of a quantity, in compiled code and of an empty tuple, too (kernel.jit)."""

    def ask(quantity: Any, *given: Any) -> Any:
        return getattr(quantity, name)(*given)

    ask.__name__, ask.__signature__ = name, signature(eval(f"lambda {parameters}: None"))  # type: ignore[attr-defined]
    return callable_of_an_empty_tuple(ask)


value, slope = (_method(name, "quantity, chain, view") for name in ("value", "slope"))
scale, kept = (_method(name, "quantity, chain, V") for name in ("scale", "kept"))
fold, is_known = _method("fold", "quantity, memory, t, h, now, rate"), _method("is_known", "quantity, memory")
at_end = _method("at_end", "quantity, chain, view, kept")


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


@jit
def extrapolate_one(quantity: Any, share: float, own: Array) -> None:
    """From the tighter and the looser run's number of a quantity, (2,), what it tends to, in the first one's place."""
    own[0] += share * (own[0] - own[1])


@jit
def _begin(quantity: Any, chain: Chain, V: float, memory: Array) -> None:
    memory[KEPT] = kept(quantity, chain, V)


@jit
def _look(quantity: Any, chain: Chain, view: Any, t: float, h: float, memory: Array) -> None:
    now, rate = value(quantity, chain, view), 0.0
    if not is_far_below(memory, now):
        rate = slope(quantity, chain, view)
    keep_largest(memory, t, h, now, rate)
    memory[VALUE], memory[SLOPE] = now, rate


@jit
def _fold(quantity: Any, chain: Chain, view: Any, t: float, h: float, memory: Array) -> None:
    now, rate = value(quantity, chain, view), slope(quantity, chain, view)
    fold(quantity, memory, t, h, now, rate)
    memory[VALUE], memory[SLOPE] = now, rate


@jit
def _fold_until_known(quantity: Any, chain: Chain, view: Any, t: float, h: float, memory: Array) -> None:
    if not is_known(quantity, memory):
        _fold(quantity, chain, view, t, h, memory)


@jit
def _look_last(quantity: Any, chain: Chain, view: Any, t: float, memory: Array) -> None:
    memory[FOUND], memory[WHEN] = at_end(quantity, chain, view, memory[KEPT]), t


@jit
def take_push_once(quantity: Any, push: float, t: float, memory: Array) -> None:
    """Keep the largest push of the contact within a step, reached at time t, where it exceeds what is kept."""
    if push > memory[FOUND]:
        memory[FOUND], memory[WHEN] = push, t


def _looker(quantity: Any, _chain: Any, view: Any, *_: Any) -> Any:
    """The function that looks at a quantity at the end of a step; None where the last state or `take_push` tells it."""
    if hasattr(quantity, "at_end") or (hasattr(quantity, "is_push") and hasattr(view, "tells_push")):
        return None
    return _look if not hasattr(quantity, "fold") else _fold_until_known if hasattr(quantity, "is_known") else _fold


def _kind(quantity: Any) -> Any:
    """The class of a quantity, told by its type; numba takes a tuple without fields for none."""
    return getattr(quantity, "instance_class", None)


def _each(parameters: str, chosen: Any) -> Any:
    """A loop over quantities, `parameters` after them, of which the last has a row for each; nothing where it has none.

    chosen: gives the function for a quantity and these parameters, or for their classes, or None. Compiled it is one
    call after the other: each has a type of its own. One function calls all: were each to call the next, each would be
    compiled with all that follow.
    """
    *given, rows = parameters.split(", ")

    def every(quantities: Any, *values: Any) -> None:
        for quantity, own in zip(quantities, values[-1], strict=False):
            if one := chosen(quantity, *values):
                one(quantity, *values[:-1], own)

    def compiled(quantities: Any, *kinds: Any) -> Any:
        ones = {f"one{k}": chosen(_kind(kind), *map(_kind, kinds)) for k, kind in enumerate(quantities)}
        calls = [
            f"        {name}(quantities[{name[3:]}], {', '.join(given)}, {rows}[{name[3:]}])\n"
            for name in ones
            if ones[name]
        ]
        source = f"def compiled(quantities, {parameters}):\n    if len({rows}) > 0:\n{''.join(calls)}        return\n"
        exec(source, ones | {"__name__": __name__}, found := dict[str, Any]())
        return found["compiled"]

    compiled.__signature__ = signature(eval(f"lambda quantities, {parameters}: None"))  # type: ignore[attr-defined]
    overload(every, strict=False)(compiled)
    return every


divide = _each("chain, V, found", lambda *_: divide_one)
extrapolate = _each("share, both", lambda quantity, *_: None if hasattr(quantity, "counts") else extrapolate_one)
begin = _each("chain, V, memory", lambda quantity, *_: _begin if hasattr(quantity, "kept") else None)  # before a run
look = _each("chain, view, t, h, memory", _looker)  # at the end of a step from t to t + h
# The largest push within a step, and its time t, which the integrator tells.
take_push = _each("push, t, memory", lambda quantity, *_: take_push_once if hasattr(quantity, "is_push") else None)
look_at_end = _each("chain, view, t, memory", lambda quantity, *_: _look_last if hasattr(quantity, "at_end") else None)


@jit
def largest_of(watch: Watch, chain: Chain, V: float) -> Array:
    """(quantities,): the number of each after a run, over its scale."""
    found = watch.memory[:, FOUND : FOUND + 1].copy()
    divide(watch.quantities, chain, V, found)
    return found.ravel()


def asks_for_push(quantities: Any) -> bool:
    """Whether one of them is the contact's largest push, which is over within one step of the chain."""
    return any(hasattr(quantity, "is_push") for quantity in quantities)


def told_by_splittings(chain: Chain, quantities: Any) -> bool:
    """Whether their steps tell all of these: of the first sites they do not, nor where the push enters."""
    return chain.site >= TOLD_FROM and not any(hasattr(quantity, "sees_impactor") for quantity in quantities)


@overload(asks_for_push)
def _compiled_asks_for_push(quantities):  # type: ignore[no-untyped-def]
    asks = any(hasattr(_kind(kind), "is_push") for kind in getattr(quantities, "types", ()))
    return (lambda quantities: True) if asks else (lambda quantities: False)


@overload(told_by_splittings)
def _compiled_told_by_splittings(chain, quantities):  # type: ignore[no-untyped-def]
    if any(hasattr(_kind(kind), "sees_impactor") for kind in getattr(quantities, "types", ())):
        return lambda chain, quantities: False
    return lambda chain, quantities: chain.site >= TOLD_FROM
