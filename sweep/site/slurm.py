"""SLURM: everything that the sweep knows of it, but for the script that the file scripts/sweep.sbatch holds."""

import re
import subprocess
import time
from collections.abc import Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from sweep.site import asking, scripts
from sweep.site.scheduler import Request, Scheduler

TEMPLATE = scripts.FOLDER / "sweep.sbatch"
ARRAY_LOG = "%x-%A_%a.log"  # of each task of an array
SIZED = "array|cpus|distribution|exclusive|gpus|gres|nodes|ntasks|signal|time"  # begins what a merge does not get
# Seconds between the signal and the time limit, in which even long running tasks end; of a short job one of so many
# parts.
NOTICE_MAX, NOTICE_PART = 300, 4
TIMES = (  # SLURM's forms
    r"(?P<minutes>\d+)",
    r"(?:(?P<hours>\d+):)?(?P<minutes>\d+):(?P<seconds>\d+)",
    r"(?P<days>\d+)-(?P<hours>\d+)(?::(?P<minutes>\d+)(?::(?P<seconds>\d+))?)?",
)
# Options of sbatch that `sweep submit` has itself: the signal, the shards and the launcher follow from them.
OURS = {"time": "--time", "ntasks": "--ranks", "array": "--array"}
COMMANDS = ("sbatch", "squeue", "scontrol", "scancel", "sinfo")
PARTITIONS = ["sinfo", "--noheader", "--format=%R %a"]  # which it must ask the controller for
CLOCKS_AGREE = 5.0  # seconds: less is the answer's way, and what network time leaves
CLOCK_WITHIN = 5.0  # seconds in which the controller tells its time; without it clocks are taken to agree


class Slurm(Scheduler):
    """What `Scheduler` asks, by SLURM's environment variables and commands."""

    name, command, ending = "SLURM", "sbatch", ".sbatch"
    option_example = "--mem=4G"
    launcher = "srun --mpi=... (srun --mpi=list)"
    size_variable = "SLURM_STEP_NUM_TASKS"  # not SLURM_NTASKS: an allocation's shell has it too
    rank_variable = "SLURM_PROCID"

    def job(self, environment: Mapping[str, str]) -> str:
        """`7`, or `7_3 restart 1` for the array task 3 of job 7 that was queued again."""
        array, task = (environment.get(f"SLURM_ARRAY_{name}_ID", "") for name in ("JOB", "TASK"))
        job = f"{array}_{task}" if array else environment.get("SLURM_JOB_ID", "")
        restarts = environment.get("SLURM_RESTART_COUNT", "0")
        return f"{job} restart {restarts}" if job and restarts != "0" else job

    def end(self, environment: Mapping[str, str]) -> float | None:
        """By this node's clock: the controller's, by which it ends jobs, may differ by an hour."""
        if not (job := self.job(environment).partition(" ")[0]):
            return None
        if (end := environment.get("SLURM_JOB_END_TIME", "")).isdecimal():
            instant = float(end)
        else:
            try:
                instant = datetime.fromisoformat(
                    asking.answer("squeue", "-h", "-j", job, "-o", "%e").strip()
                ).timestamp()
            except (OSError, subprocess.SubprocessError, ValueError):  # no squeue here, or the job has no end
                return None
        return instant + _ahead()

    def idle(self, environment: Mapping[str, str]) -> str:
        """A job's shell (salloc, sbatch) may start one process on purpose, or for want of a launcher."""
        if not (text := environment.get("SLURM_NTASKS", "")).isdecimal() or int(text) <= 1:
            return ""
        return f"SLURM_NTASKS={text}, but this is one process, started without mpirun or srun: the others stay idle"

    def seconds_of(self, time: str) -> int:
        return scripts.seconds_of(time, TIMES, "as SLURM writes it, for example 90, 12:00:00 or 2-00")

    def time_of(self, seconds: float) -> str:
        """`H:MM:SS`, whole minutes."""
        return f"{scripts.clock(seconds)}:00"

    def option_problem(self, option: str) -> str:
        if not (found := re.fullmatch(r"--([a-z][a-z-]*)(=[^\n]+)?", option)):
            return "must be an option of sbatch, --name or --name=value"
        return f"must be given to sweep submit, as {OURS[found[1]]}" if found[1] in OURS else ""

    def script(self, request: Request) -> str:
        limit = request.time or ""
        settings = {"job-name": request.name, "ntasks": str(request.ranks), "time": limit}
        settings |= {"signal": f"B:USR1@{notice(self.seconds_of(limit))}", **request.places}
        settings |= _settings_of(request)
        values = {"spec": str(request.spec), "table": str(request.table), "bin": str(request.commands)}
        values["writer"] = request.writer
        if request.array:
            settings |= {"array": f"1-{request.array}", "output": ARRAY_LOG}
            values["shards"] = str(request.array)
        return render(settings, values)

    def submit(self, script: Path) -> list[str]:
        return ["sbatch", "--parsable", str(script)]

    def follow(self, request: Request, job: str, then: str) -> list[str]:
        given = {name: value for name, value in _settings_of(request).items() if not re.match(SIZED, name)}
        options = request.places | given
        options |= {"job-name": f"{request.name}-merge", "ntasks": "1", "output": "%x-%j.log"}
        wait = {"dependency": f"afterany:{job}", "wrap": then}
        return ["sbatch", "--parsable", *(_option(name, value) for name, value in (options | wait).items())]

    def number_in(self, answer: str) -> str:
        return answer.strip().partition(";")[0]  # of several clusters, the name of one follows

    def examine(self) -> tuple[bool, str]:
        can, told = asking.reached(COMMANDS, PARTITIONS, "its controller")
        if not can:
            return False, told
        lines = map(str.split, told.splitlines())  # of which a site may add some
        up = sorted({words[0] for words in lines if words[1:] == ["up"]})
        if not up:
            return False, "its controller answers, but no partition is up: jobs would wait"
        return True, f"jobs can be submitted from here (sweep submit), to {', '.join(up)}"


def _ahead() -> float:
    """Seconds by which this node's clock is ahead of the controller's; 0 where nobody tells."""
    told = None
    with suppress(OSError, subprocess.SubprocessError):
        told = re.search(r"^sdiag output at .*\((\d+)\)", asking.answer("sdiag", within=CLOCK_WITHIN), re.MULTILINE)
    if told and abs(ahead := time.time() - float(told[1])) > CLOCKS_AGREE:
        return ahead
    return 0.0


def render(settings: Mapping[str, str], values: Mapping[str, str]) -> str:
    """The script with these options of sbatch, and with these shell variables set instead of taken from outside."""
    lines = TEMPLATE.read_text().splitlines()
    left = dict(settings)
    for i, line in enumerate(lines):
        if (option := re.match(r"#SBATCH --([a-z-]+)=", line)) and option[1] in left:
            lines[i] = f"#SBATCH {_option(option[1], left.pop(option[1]))}"
        else:
            lines[i] = scripts.with_value(line, values)
    last = max(i for i, line in enumerate(lines) if line.startswith("#SBATCH"))
    lines[last + 1 : last + 1] = [f"#SBATCH {_option(name, value)}" for name, value in left.items()]
    return "\n".join(lines) + "\n"


def _settings_of(request: Request) -> dict[str, str]:
    """The further options by name."""
    parts = (option.removeprefix("--").partition("=") for option in request.others)
    return {name: value for name, _, value in parts}


def _option(name: str, value: str) -> str:
    return f"--{name}={value}" if value else f"--{name}"


def notice(limit: int) -> int:
    """Seconds before a limit, in seconds too, at which to stop: a quarter of a short job is left."""
    return min(NOTICE_MAX, limit // NOTICE_PART)
