"""IBM Spectrum LSF: what the sweep knows of it. Made from its documentation; tried on none."""

import re
import shlex
import subprocess
import time
from collections.abc import Mapping
from itertools import chain
from pathlib import Path

from sweep.site import asking, scripts
from sweep.site.scheduler import Request, Scheduler

PLACES = {"partition": "-q", "account": "-P"}
TIMES = (r"(?:(?P<hours>\d+):)?(?P<minutes>\d+)",)  # LSF's form
# Options that are not for the job that merges: its size, time, name and order are its own.
SIZED = r"-(n|W|We|J|w|o|Q|r|x|gpu)\b|-R .*\b(span|affinity)\b"


class Lsf(Scheduler):
    """What `Scheduler` asks, by LSF's environment variables and commands."""

    name, command, ending = "LSF", "bsub", ".lsf"
    option_example = "-R 'span[ptile=16]'"

    def job(self, environment: Mapping[str, str]) -> str:
        """`7`, or `7[3]` of an array."""
        job, index = (environment.get(name, "") for name in ("LSB_JOBID", "LSB_JOBINDEX"))
        return f"{job}[{index}]" if job and index not in ("", "0") else job

    def end(self, environment: Mapping[str, str]) -> float | None:
        """From the time that LSF says is left, so that no two clocks are compared."""
        if not (job := self.job(environment)):
            return None
        try:
            left = asking.answer("bjobs", "-noheader", "-o", "time_left", job).strip()
            return time.time() + self.seconds_of(left.partition(" ")[0])
        except (OSError, subprocess.SubprocessError, ValueError):  # no bjobs here, or the job has no end
            return None

    def seconds_of(self, time: str) -> int:
        return scripts.seconds_of(time, TIMES, "as LSF writes it, [hours:]minutes, for example 90 or 12:00")

    def time_of(self, seconds: float) -> str:
        """`H:MM`."""
        return scripts.clock(seconds)

    def option_problem(self, option: str) -> str:
        good = re.fullmatch(r"-[a-zA-Z_]+( [^\n]+)?", option) and scripts.is_quoted_well(option)
        return "" if good else "must be an option of bsub, '-x' or '-x value'"

    def script(self, request: Request) -> str:
        name = f'"{request.name}[1-{request.array}]"' if request.array else request.name
        options = [f"-J {name}", f"-n {request.ranks}", f"-W {request.time}", "-r", '-Q "75"']
        options += ["-o %J-%I.log" if request.array else "-o %J.log"]
        options += map(" ".join, scripts.places_of(request, PLACES))
        lines = [f"#BSUB {option}" for option in (*options, *request.others)]
        return scripts.filled("sweep.lsf", lines, scripts.values_of(request))

    def submit(self, script: Path) -> list[str]:
        return ["bash", "-c", f"bsub < {shlex.quote(str(script))}"]  # read from a file, directives would not count

    def follow(self, request: Request, job: str, then: str) -> list[str]:
        options = chain.from_iterable(scripts.places_of(request, PLACES))
        wait = ["-w", f"ended({job})", "-J", f"{request.name}-merge", "-o", "%J.log"]
        return ["bsub", *wait, *options, *scripts.others_of(request, SIZED), then]

    def number_in(self, answer: str) -> str:
        found = re.search(r"Job <(\d+)>", answer)
        return found[1] if found else answer.strip()

    def examine(self) -> tuple[bool, str]:
        can, told = asking.reached(["bsub", "bjobs", "bqueues"], ["bqueues"], "it")
        return can, asking.UNTRIED if can else told
