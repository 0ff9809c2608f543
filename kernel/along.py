"""How mass, stiffness or damping goes along a chain: evenly, from one end to the other, at random, or as a list says.

All over the values of the uniform chain. Random ones follow from a seed and their place alone: the first sites of a
longer chain are those of a shorter one, on every machine (numpy promises the bits of PCG64, not those of its floats).
"""

from typing import Any, NamedTuple

import numpy as np

from kernel.hints import shown
from kernel.model import Array
from kernel.task import MODEL_BOX, SEED, breaking, is_finite, outside

KINDS = ("mass", "stiffness", "damping")
SPREAD_MAX = 0.99
BITS_DROPPED, TO_UNIT = np.uint64(11), 2.0**-53  # the 53 highest of 64 bits are a float's digits


class Graded(NamedTuple):
    """Evenly from `first` at the struck end to `last` at the wall.

    Parameters
    ----------
    first, last : float
        Over the value of the uniform chain; ranges are those of the number that it stands for (`Model`).

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Model(mass=kernel.Graded(1.0, 2.0)).numbers()["mass.last"]
    2.0
    """

    first: float
    last: float

    def values(self, n: int, kind: str) -> Array:
        """(n,) from the first to the last."""
        return np.linspace(self.first, self.last, n)

    def problems(self, kind: str) -> list[str]:
        """Every number that breaks its rule."""
        return outside(*MODEL_BOX[kind], first=self.first, last=self.last)


class Disordered(NamedTuple):
    """Random and independent, evenly distributed from 1 - spread to 1 + spread.

    Parameters
    ----------
    spread : float
        0 to 0.99.
    seed : int
        0 to 2**32 - 1; the same seed gives mass, stiffness and damping different numbers.

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> kernel.Disordered(0.1, 7).values(3, "mass").round(3).tolist()
    [1.025, 1.079, 1.055]
    """

    spread: float
    seed: int = 0

    def values(self, n: int, kind: str) -> Array:
        """(n,) numbers; the first of them do not depend on n."""
        bits = np.random.PCG64([int(self.seed), KINDS.index(kind)]).random_raw(n)
        return np.asarray(1.0 + self.spread * (2.0 * TO_UNIT * (bits >> BITS_DROPPED) - 1.0), np.float64)

    def problems(self, kind: str) -> list[str]:
        """Every number that breaks its rule."""
        return outside(0.0, SPREAD_MAX, spread=self.spread) + breaking(SEED, seed=self.seed)


FORMS: tuple[Any, ...] = (Graded, Disordered)


def problems_of(kind: str, given: Any) -> list[str]:
    """What is wrong with the mass, stiffness or damping that was given, each line with its key."""
    if isinstance(given, Graded | Disordered):
        return [f"{kind}.{line}" for line in given.problems(kind)]
    low, high = MODEL_BOX[kind]
    given = plain(given)
    if isinstance(given, tuple | list):
        named = {f"{kind}[{k}]": value for k, value in enumerate(given)}
        return outside(low, high, **named) if given else [f"{kind}: must not be empty"]
    if is_finite(given):
        return outside(low, high, **{kind: given})
    rule = f"must be a number from {low:g} to {high:g}, a kernel.Graded, a kernel.Disordered or a list of N numbers"
    return [f"{kind}: {rule}, got {shown(given)}"]


def plain(given: Any) -> Any:
    """A row of an array, of pandas too, as a list; anything else as it is."""
    return given.tolist() if getattr(given, "ndim", 0) == 1 else given


def as_kept(given: Any) -> Any:
    """With floats for whole numbers and tuples for lists."""
    given = plain(given)
    if isinstance(given, Graded | Disordered):
        return type(given)(*map(float, given))  # type: ignore[arg-type]
    return tuple(map(float, given)) if isinstance(given, tuple | list) else float(given)


def values_along(given: Any, n: int, kind: str) -> Array:
    """(n,) of a chain of n."""
    if isinstance(given, Graded | Disordered):
        return given.values(n, kind)
    return np.array(given) if isinstance(given, tuple) else np.full(n, given)


def from_settings(kind: str, given: Any) -> Any:
    """What a spec's { first, last } or { spread, seed } means; anything else as it is. ValueError where it is none."""
    if not isinstance(given, dict):
        return given
    for form in FORMS:
        missing = [name for name in form._fields if name not in given and name not in form._field_defaults]
        if set(given) <= set(form._fields) and not missing:
            return form(**given)
    raise ValueError(
        f"{kind}: must be a number, {{ first = a, last = b }}, {{ spread = s, seed = k }} or a list, got {shown(given)}"
    )
