"""Everything that is wrong with some arguments, in one error."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

E = TypeVar("E", bound=Exception)


class ProblemsError(ValueError):
    """Several problems, one line each, with the key, the rule and the value."""

    def __init__(self, lines: Iterable[str]) -> None:
        self.lines = tuple(lines)
        super().__init__("; ".join(self.lines))

    def __reduce__(self) -> "tuple[type[ProblemsError], tuple[tuple[str, ...]]]":
        return type(self), (self.lines,)  # else a process that receives it would take the text for the lines


def lines_of(error: ValueError) -> tuple[str, ...]:
    """The problems that an error names; of an error of another kind its text."""
    return error.lines if isinstance(error, ProblemsError) else (str(error),)


def tried(
    makers: Iterable[Callable[[], Any]], caught: type[E], lines_of: Callable[[E], Iterable[str]]
) -> tuple[list[Any], list[str]]:
    """What the makers return, and the problems of all of them that raise such an error."""
    made, problems = list[Any](), list[str]()
    for maker in makers:
        try:
            made.append(maker())
        except caught as error:
            problems += lines_of(error)
    return made, problems
