"""PBS Professional and OpenPBS: what the sweep knows of them. Made from their documentation; tried on none."""

import re
import subprocess
import time
from collections.abc import Mapping
from datetime import datetime
from itertools import chain
from pathlib import Path

from sweep.site import asking, scripts
from sweep.site.scheduler import Request, Scheduler

USE_LAGS = 120.0  # seconds by which the used time that PBS tells may be old: its daemons report every two minutes
PLACES = {"partition": "-q", "account": "-A"}
TIMES = (r"(?:(?:(?P<hours>\d+):)?(?P<minutes>\d+):)?(?P<seconds>\d+)",)  # PBS's form
# Options that are not for the job that merges: its size, time, name and order are its own.
SIZED = r"-[JN]\b|-W .*\bdepend|-l .*\b(select|place|nodes|ncpus|mpiprocs|ngpus|walltime|cput)\b"
NAME_MAX = 230  # letters of a job's name that PBS takes
MERGE = "-merge"  # behind the name, of the job that merges
CLOCKS_AGREE = 600.0  # seconds: where start and used time differ by more, two clocks do


class Pbs(Scheduler):
    """What `Scheduler` asks, by the environment variables and commands of PBS."""

    name, command, ending = "PBS", "qsub", ".pbs"
    option_example = "-l place=scatter"

    def job(self, environment: Mapping[str, str]) -> str:
        """`7.server`, or `7[3].server` of an array."""
        return environment.get("PBS_JOBID", "")

    def end(self, environment: Mapping[str, str]) -> float | None:
        if not (job := self.job(environment)):
            return None
        try:
            answer = asking.answer("qstat", "-f", job)
        except (OSError, subprocess.SubprocessError):
            return None
        told = dict(re.findall(r"^\s+(\S+) = (.+)$", answer, re.MULTILINE))
        return _end(told, time.time())

    def seconds_of(self, time: str) -> int:
        rule = "as PBS writes it, [[hours:]minutes:]seconds, for example 12:00:00"
        return scripts.seconds_of(time, TIMES, rule)

    def time_of(self, seconds: float) -> str:
        """`H:MM:SS`, whole minutes."""
        return f"{scripts.clock(seconds)}:00"

    def option_problem(self, option: str) -> str:
        good = re.fullmatch(r"-[a-zA-Z]( [^\n]+)?", option) and scripts.is_quoted_well(option)
        return "" if good else "must be an option of qsub, '-x' or '-x value'"

    def script(self, request: Request) -> str:
        options = [f"-N {request.name[:NAME_MAX]}", f"-l select={request.ranks}:ncpus=1:mpiprocs=1"]
        options += [f"-l walltime={request.time}", "-j oe"]
        options += map(" ".join, scripts.places_of(request, PLACES))
        lines = [f"#PBS {option}" for option in (*options, *request.others)]
        table = request.table
        own = str(table.with_suffix(self.ending)) if table else ""
        return scripts.filled("sweep.pbs", lines, scripts.values_of(request) | {"script": own})

    def submit(self, script: Path) -> list[str]:
        shards = re.search(r"^shards=(\d+)$", script.read_text(*scripts.AS_BYTES), re.MULTILINE)
        # Not in the script, which a shard that stopped early submits by itself. An array of one PBS does not take.
        array = ["-J", f"1-{shards[1]}"] if shards and int(shards[1]) > 1 else []
        return ["qsub", *array, str(script)]

    def follow(self, request: Request, job: str, then: str) -> list[str]:
        options = chain.from_iterable(scripts.places_of(request, PLACES))
        name = request.name[: NAME_MAX - len(MERGE)] + MERGE
        wait = ["-W", f"depend=afterany:{job}", "-N", name, "-j", "oe", *options]
        return ["qsub", *wait, *scripts.others_of(request, SIZED), "--", "/bin/bash", "-c", then]

    def examine(self) -> tuple[bool, str]:
        can, told = asking.reached(["qsub", "qstat"], ["qstat", "-B"], "its server")
        return can, asking.UNTRIED if can else told


def _end(told: Mapping[str, str], now: float) -> float | None:
    """By this node's clock: that of the server, by which a job starts, may differ by an hour."""
    try:
        limit = scripts.seconds_of(told["Resource_List.walltime"], TIMES, "")
        used = scripts.seconds_of(told.get("resources_used.walltime", "0"), TIMES, "")
        by_use = now + limit - used - USE_LAGS
        started = datetime.strptime(told["stime"], "%a %b %d %H:%M:%S %Y").timestamp()
    except (KeyError, ValueError):
        return None
    return started + limit if abs(started + limit - by_use) < CLOCKS_AGREE else by_use
