"""The numbers beside the axes of a map: every value where there are few, else round ones; they never overlap."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

import numpy as np

from analysis.ruler import RELATIVE_MATCH, Ruler

_LABELLED_MAX = 8  # cells that carry their value each; of more only round values are labelled
_LETTER_WIDTH, _LINE_HEIGHT = 0.075, 0.19  # inches of a label, with the room about it
DIGITS, _DIGITS_MOST = 3, 17  # of a label, and where two numbers are alike in these; 17 tell all
Share = Callable[[float], float]  # how far along an axis a value stands, 0 to 1


@dataclass(frozen=True)
class Ticks:
    """Places (values of the parameter) with labels, and values between that carry a short stroke only."""

    places: list[float]
    labels: list[str]
    minor: list[float]


def ticks(ruler: Ruler, inches: float, across: bool) -> Ticks:
    """Ticks for an axis of so many inches; `across`: its labels stand side by side, else above each other."""
    values = ruler.values.tolist()
    positive = values[1:] if ruler.gap else values
    tries = [values] if len(values) <= _LABELLED_MAX else []
    for rounds in _rounds(ruler, positive):
        tries.append([0.0, *rounds] if ruler.gap else list(rounds))
    roomy = [some for some in tries if len(some) >= min(3, len(values)) and _fits(some, ruler.share, inches, across)]
    chosen = roomy[0] if roomy else _thinned(values, ruler.share, inches, across)
    minor = _multiples(positive, range(1, 10)) if ruler.log and chosen != values else []
    return Ticks(chosen, labels(chosen), minor)


def labels(values: Sequence[float]) -> list[str]:
    """Of different numbers different labels, with as many digits as that takes."""
    every, digits = len(set(values)), DIGITS
    while len({label(value, digits) for value in values}) < every and digits < _DIGITS_MOST:
        digits += 1
    return [label(value, digits) for value in values]


def label(value: float, digits: int = DIGITS) -> str:
    """A number as it stands in a picture: 200, 0.01, or with a power of ten in mathtext."""
    shown = abs(float(f"{value:.{digits}g}"))  # what is just below a thousand stands there as 1000
    if shown == 0 or 1e-2 <= shown < 1e4:
        return f"{value:.{digits}g}" if shown < 10**digits else f"{value:.0f}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".")
    power = f"10^{{{int(exponent)}}}"
    if mantissa in ("1", "-1"):
        return f"${mantissa[:-1]}{power}$"
    return rf"${mantissa}{{\times}}{power}$"


def beside(tries: Sequence[Sequence[float]], share: Share, inches: float, first: float) -> list[float]:
    """The first of these sets of numbers that has room beside a bar; of the last, what has from `first` outwards."""
    roomy = [some for some in tries if _fits(some, share, inches, across=False)]
    if roomy:
        return list(roomy[0])
    nearest = sorted(tries[-1], key=lambda value: abs(share(value) - share(first)))
    return _thinned(nearest, share, inches, across=False)


def _fits(values: Sequence[float], share: Share, inches: float, across: bool) -> bool:
    places = np.array([share(value) for value in values]) * inches
    sizes = np.array([_letters(text) * _LETTER_WIDTH if across else _LINE_HEIGHT for text in labels(values)])
    return bool((np.diff(places) >= (sizes[1:] + sizes[:-1]) / 2).all())


def _letters(text: str) -> int:
    """The width of a label, in letters; an exponent is small."""
    seen = text.replace(r"{\times}", "x").replace("^", "").translate(str.maketrans("", "", "${}"))
    return len(seen) - (1 if "$" in text else 0) + 1


def _thinned(values: Sequence[float], share: Share, inches: float, across: bool) -> list[float]:
    """As many of the values as have room, ascending; those that come first have it first."""
    chosen = list(values[:1])
    for value in values[1:]:
        if _fits(sorted([*chosen, value]), share, inches, across):
            chosen.append(value)
    return sorted(chosen)


def _rounds(ruler: Ruler, values: Sequence[float]) -> list[list[float]]:
    """Sets of round numbers in the range of the values, the preferred one first."""
    if not ruler.log:
        return [linear(values[0], values[-1])]
    decades = _multiples(values, (1,))
    sparse = [decades[::every] for every in (1, 2, 3, 5, 10, 20, 50, 100)]
    few = [_multiples(values, (1, 2, 5)), _multiples(values, (1, 3))]
    return [*sparse, *few] if len(decades) >= 4 else [*few, linear(values[0], values[-1]), decades]


def _multiples(values: Sequence[float], factors: Sequence[int]) -> list[float]:
    """These factors times powers of ten, from the first to the last of the positive values."""
    low, high = values[0] * (1 - RELATIVE_MATCH), values[-1] * (1 + RELATIVE_MATCH)
    exponents = range(floor(log10(low)), ceil(log10(high)) + 1)
    numbers = [float(f"{factor}e{exponent}") for exponent in exponents for factor in factors]
    return [number for number in numbers if low <= number <= high]


def scale_ticks(low: float, high: float) -> list[float]:
    """For a logarithmic scale from `low` to `high`: decades where it is long, else 1, 2, 5 times these, or less."""
    some = [_multiples((low, high), factors) for factors in ((1,), (1, 2, 5))]
    return next((numbers for numbers in some if len(numbers) >= 3), linear(low, high))


def linear(low: float, high: float, most: int = 6) -> list[float]:
    """Multiples of 1, 2 or 5 times a power of ten from `low` to `high`: about `most` at most, and three at least."""
    if not high > low:
        return [low]
    rough = (high - low) / most
    power = 10.0 ** floor(log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough)
    first, last = ceil(low / step - RELATIVE_MATCH), floor(high / step + RELATIVE_MATCH)
    found = [float(f"{count * step:.12g}") for count in range(first, last + 1)]
    return found if len(found) >= 3 else linear(low, high, 2 * most)
