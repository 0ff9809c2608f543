"""The scripts of the folder `scripts`, with a sweep's names and a scheduler's directives in their places."""

import math
import re
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path

from sweep.site.scheduler import Request

FOLDER = Path(__file__).with_name("scripts")
AS_BYTES = "utf-8", "surrogateescape"  # how a script is read and written: a path in it need not be text
UNITS = {"days": 86400, "hours": 3600, "minutes": 60, "seconds": 1}
MARK = "# DIRECTIVES"  # a line of a template, in whose place the directives stand


def filled(name: str, directives: Iterable[str], values: Mapping[str, str]) -> str:
    """The script `name` with these lines, and with these shell variables set instead of taken from its arguments."""
    lines: list[str] = []
    for line in (FOLDER / name).read_text().splitlines():
        lines += directives if line == MARK else [with_value(line, values)]
    return "\n".join(lines) + "\n"


def with_value(line: str, values: Mapping[str, str]) -> str:
    """The line; where it takes from outside a shell variable that `values` has, it takes that value instead."""
    variable = re.match(r"([a-z]+)=\$", line)
    return f"{variable[1]}={shlex.quote(values[variable[1]])}" if variable and variable[1] in values else line


def places_of(request: Request, options: Mapping[str, str]) -> list[tuple[str, str]]:
    """Partition and account, where they are given, each behind the option that takes it (`options`)."""
    return [(options[name], value) for name, value in request.places.items()]


def is_quoted_well(option: str) -> bool:
    """Whether every quote ends."""
    try:
        shlex.split(option)
    except ValueError:
        return False
    return True


def others_of(request: Request, own: str) -> list[str]:
    """The words of the further options for the job that merges: a site may ask each job for its group or its memory.

    own: what options match that are about what this job has of its own.
    """
    return [word for option in request.others if not re.match(own, option) for word in shlex.split(option)]


def values_of(request: Request) -> dict[str, str]:
    """What every script must know of a request."""
    return {
        "spec": str(request.spec),
        "table": str(request.table),
        "bin": str(request.commands),
        "writer": request.writer,
        "ranks": str(request.ranks),
        "shards": str(request.array or ""),
    }


def clock(seconds: float) -> str:
    """`hours:minutes`, not below."""
    hours, minutes = divmod(math.ceil(seconds / 60), 60)
    return f"{hours}:{minutes:02}"


def seconds_of(time: str, forms: Iterable[str], rule: str) -> int:
    """Seconds of a time in one of these forms, whose groups are named as in UNITS; ValueError where it is in none."""
    found = next((match for form in forms if (match := re.fullmatch(form, time, re.ASCII))), None)
    if found is None:
        raise ValueError(f"must be a time {rule}, got {time!r}")
    return sum(UNITS[name] * int(text or 0) for name, text in found.groupdict().items())
