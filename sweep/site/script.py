"""The SLURM script of a sweep: the one in `scripts`, with other settings and the names filled in."""

import math
import re
import shlex
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

TEMPLATE = "scripts/sweep.sbatch"
ARRAY = {"array": "1-16", "ntasks": "1", "output": "%x-%A_%a.log"}  # what jobs/array.sbatch has of its own
NOTICE_MAX = 300  # seconds between the signal and the time limit
TIMES = (  # SLURM's forms
    r"(?P<minutes>\d+)",
    r"(?:(?P<hours>\d+):)?(?P<minutes>\d+):(?P<seconds>\d+)",
    r"(?P<days>\d+)-(?P<hours>\d+)(?::(?P<minutes>\d+)(?::(?P<seconds>\d+))?)?",
)


def render(settings: Mapping[str, str], values: Mapping[str, str]) -> str:
    """The script with these options of sbatch, and with these shell variables set instead of taken from outside."""
    lines = resources.files("sweep.site").joinpath(TEMPLATE).read_text().splitlines()
    left = dict(settings)
    for i, line in enumerate(lines):
        if (option := re.match(r"#SBATCH --([a-z-]+)=", line)) and option[1] in left:
            lines[i] = _option(option[1], left.pop(option[1]))
        elif (variable := re.match(r"([a-z]+)=\$", line)) and variable[1] in values:
            lines[i] = f"{variable[1]}={shlex.quote(values[variable[1]])}"
    last = max(i for i, line in enumerate(lines) if line.startswith("#SBATCH"))
    lines[last + 1 : last + 1] = [_option(name, value) for name, value in left.items()]
    return "\n".join(lines) + "\n"


def _option(name: str, value: str) -> str:
    return f"#SBATCH --{name}={value}" if value else f"#SBATCH --{name}"


def seconds_of(time: str) -> int:
    """A time limit as SLURM writes it; ValueError where it is not one."""
    found = next((match for form in TIMES if (match := re.fullmatch(form, time))), None)
    if found is None:
        raise ValueError(f"must be a time as SLURM writes it, for example 90, 12:00:00 or 2-00, got {time!r}")
    units = {"days": 86400, "hours": 3600, "minutes": 60, "seconds": 1}
    return sum(units[name] * int(text or 0) for name, text in found.groupdict().items())


def time_of(seconds: float) -> str:
    """`H:MM:SS`, whole minutes, not below."""
    hours, minutes = divmod(math.ceil(seconds / 60), 60)
    return f"{hours}:{minutes:02}:00"


def notice(time: str) -> int:
    """Seconds before the limit at which to stop: a quarter of a short job is left."""
    return min(NOTICE_MAX, seconds_of(time) // 4)


def shard_table(table: Path, index: int, count: int) -> Path:
    """The name that the script gives to the table of one shard."""
    return table.with_name(f"{table.name.removesuffix('.h5')}-{index}-of-{count}.h5")
