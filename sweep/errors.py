"""How a command ends, and what a user can mend: reported as one message, exit status 2, nothing written."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from kernel.problems import tried

ALL_DONE, SOME_FAILED, BAD_INPUT, STOPPED_EARLY = 0, 1, 2, 75
PROBLEMS_MAX = 20  # of one kind that are told: a range may hold a million values
EXIT_STATUS = (
    "exit status: 0 all rows done; 1 some rows failed, or more than --max-fails; 2 bad input or environment; "
    "75 stopped early, run again"
)


class InputError(ValueError):
    """Bad input or environment, a ValueError as the kernel raises one; `problems` holds one line each."""

    def __init__(self, *problems: str) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems


def gathered(*checks: Callable[[], Any]) -> list[Any]:
    """What the checks give; one InputError with the problems of all that raise one."""
    given, problems = tried(checks, InputError, lambda error: error.problems)
    if problems:
        raise InputError(*dict.fromkeys(problems))  # two checks may find the same
    return given


def refuse_all(problems: Sequence[str]) -> None:
    """One InputError with these problems, if there are any."""
    if problems:
        raise InputError(*problems)


def some_of(told: Iterable[str], more: str = "and {} more") -> list[str]:
    """The first PROBLEMS_MAX, and how many more there are."""
    every = list(told)
    left = len(every) - PROBLEMS_MAX
    return every if left <= 0 else [*every[:PROBLEMS_MAX], more.format(left)]


def status_of(failed: int, left: int) -> int:
    """The exit status after so many failed rows, where so many are left that another run computes."""
    return STOPPED_EARLY if left else SOME_FAILED if failed else ALL_DONE


def of_system(error: OSError) -> str:
    """What the system refuses, in one line; empty where it names no file, as only a bug of ours can say it so."""
    if error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    try:
        os.getcwd()  # noqa: PTH109 # a relative path is looked for from here
    except OSError:
        return f"the current folder: {error.strerror}"
    return ""


@contextmanager
def writing(path: object) -> Iterator[None]:
    """What the disk refuses while `path` is written becomes an InputError: the user mends it."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None


class UnwritableTableError(InputError):
    """A table that could be written before, and no longer can."""

    def __init__(self, path: object, error: Exception) -> None:
        number = getattr(error, "errno", None)
        why = os.strerror(number) if number else " ".join(str(error).split())
        super().__init__(
            f"{path}: cannot be written any more ({why}); what was reported done is kept: make room, then run again"
        )


class DamagedTableError(InputError):
    """A table whose structure cannot be trusted; its rows may be intact."""

    def __init__(self, path: object, what: str) -> None:
        remedy = "`sweep run --repair` with its spec saves the intact rows and computes the others"
        super().__init__(f"{path}: {what}; {remedy}")
