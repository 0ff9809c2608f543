"""`sweep submit`: write the SLURM script of a sweep and hand it to sbatch where there is one."""

import math
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sweep.errors import InputError
from sweep.files import wrong_ending
from sweep.plan.shard import SHARDS_MAX
from sweep.plan.spec import Spec, read_spec
from sweep.site.script import ARRAY, notice, render, shard_table, time_of
from sweep.tell import report

RANKS_MAX = 64  # unless asked for more
WORTH = 600.0  # seconds of predicted work that each rank gets at least
MARGIN, START = 2.0, 600.0  # of the predicted time; and seconds, for compiling and for opening files
ARRAY_JOB = "ARRAY_JOB"  # stands for its number before there is one
TIME_MAX = 12 * 3600.0  # unless asked for more: what does not fit is queued again


@dataclass(frozen=True)
class Wish:
    """What the user asked for; None or empty where the plan is to decide."""

    spec: Path
    table: Path | None = None
    ranks: int | None = None
    time: str | None = None
    array: int | None = None
    partition: str | None = None
    account: str | None = None
    others: tuple[str, ...] = ()


@dataclass(frozen=True)
class Order:
    """A script, and the commands that submit it and what follows it."""

    script: Path
    text: str
    submit: list[str]
    merge: list[str]  # the command for afterwards; empty without shards
    merge_options: list[str]


def order(wish: Wish) -> Order:
    """The script for a sweep; InputError naming every problem. Writes nothing."""
    spec, text = read_spec(wish.spec)
    if spec.adaptive and wish.array:
        raise InputError("--array: an adaptive sweep has no shares: what it computes follows from its results")
    _check(wish, spec.tasks)
    name = re.sub(r"[^\w.-]+", "-", spec.name)
    table = wish.table or Path(f"{name}.h5")
    if not table.name:
        raise InputError(f"--output: must name a file, got {str(wish.table)!r}")
    ranks, time = _size(wish, spec, text)
    settings = {"job-name": name, "ntasks": str(ranks), "time": time, "signal": f"B:USR1@{notice(time)}"}
    places = {key: value for key in ("partition", "account") if (value := getattr(wish, key))}
    settings |= places | dict(_pair(option) for option in wish.others)
    if wish.array:
        settings |= {"array": f"1-{wish.array}", "output": ARRAY["output"]}
    binaries = Path(sys.executable).parent.absolute()
    values = {"spec": str(wish.spec.absolute()), "table": str(table.absolute()), "bin": str(binaries)}
    script = table.with_suffix(".sbatch")
    merge = []
    if wish.array:
        values |= {"shards": str(wish.array)}
        shards = [str(shard_table(table.absolute(), k, wish.array)) for k in range(1, wish.array + 1)]
        merge = [str(binaries / "sweep"), "merge", *shards, "-o", str(table.absolute())]
    options = [f"--job-name={name}-merge", "--ntasks=1", "--output=%x-%j.log"]
    options += [f"--{key}={value}" for key, value in places.items()]
    return Order(script, render(settings, values), ["sbatch", "--parsable", str(script)], merge, options)


def submit(ordered: Order) -> str:
    """Write the script, submit it if sbatch is there; what was done, for people. InputError where sbatch refuses."""
    _write(ordered.script, ordered.text)
    if shutil.which("sbatch") is None:
        told = f"wrote {ordered.script}; no sbatch here: where there is one, run sbatch {ordered.script}"
        return f"{told}\nand when all is done, {shlex.join(ordered.merge)}" if ordered.merge else told
    job = _sbatch(ordered.submit)
    told = f"wrote {ordered.script}; submitted as job {job}"
    if not ordered.merge:
        return told
    last = _sbatch(_merge_job(ordered, job))
    return f"{told}; job {last} merges its shards when all have ended"


def rehearse(ordered: Order) -> str:
    """What `submit` would write and submit, as one shell script; the job that merges is a comment at its end."""
    script = ordered.text.rstrip("\n")
    if not ordered.merge:
        return script
    lines = shlex.join(_merge_job(ordered, ARRAY_JOB)).splitlines()  # a name may hold a line's end
    return "\n".join(
        [script, "", "# When all of the array have ended, their tables are merged by", *(f"#   {x}" for x in lines)]
    )


def _merge_job(ordered: Order, array: str) -> list[str]:
    """The command that submits what follows the job `array`."""
    wait = [f"--dependency=afterany:{array}", f"--wrap={shlex.join(ordered.merge)}"]
    return ["sbatch", "--parsable", *ordered.merge_options, *wait]


def _check(wish: Wish, tasks: int) -> None:
    problems = [problem] if wish.table and (problem := wrong_ending(wish.table)) else []
    if wish.ranks is not None and wish.ranks < 1:
        problems.append(f"--ranks: must be at least 1, got {wish.ranks}")
    if wish.array is not None and not 1 <= wish.array <= min(SHARDS_MAX, tasks):
        problems.append(f"--array: must be from 1 to {min(SHARDS_MAX, tasks)} for this sweep, got {wish.array}")
    for option in wish.others:
        if not re.fullmatch(r"--[a-z][a-z-]*(=[^\n]+)?", option):
            problems.append(f"--sbatch: must be an option of sbatch, --name or --name=value, got {option!r}")
    for name in ("partition", "account"):
        if (value := getattr(wish, name)) is not None and not re.fullmatch(r"[\w.,@:+-]+", value):
            problems.append(f"--{name}: must be a name, got {value!r}")
    if wish.time is not None:
        try:
            notice(wish.time)
        except ValueError as error:
            problems.append(f"--time: {error}")
    if problems:
        raise InputError(*problems)


def _size(wish: Wish, spec: Spec, text: str) -> tuple[int, str]:
    """Ranks and time limit, from the plan where not asked for."""
    if wish.ranks is not None and wish.time is not None:
        return wish.ranks, wish.time
    plan: dict[str, Any] = report.plan(spec, text, wish.spec.resolve().parent)
    work, shards = 3600 * plan["core_hours"], wish.array or 1
    ranks = wish.ranks or (1 if wish.array else max(1, min(RANKS_MAX, math.floor(work / WORTH))))
    wall = max(work / (ranks * shards), plan["longest_task_s"])
    return ranks, wish.time or time_of(min(TIME_MAX, MARGIN * wall + START))


def _pair(option: str) -> tuple[str, str]:
    name, _, value = option.removeprefix("--").partition("=")
    return name, value


def _write(script: Path, text: str) -> None:
    """A script that was edited since is not overwritten."""
    try:
        if script.exists() and script.read_text() != text:
            raise InputError(f"{script}: exists and says something else; sbatch it, remove it, or give another -o")
        script.write_text(text)
    except OSError as error:
        raise InputError(f"{script}: cannot be written: {error.strerror}") from None


def _sbatch(command: list[str]) -> str:
    """The job's number."""
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise InputError(f"sbatch: cannot be run: {error.strerror}") from None
    if answer.returncode:
        lines = answer.stderr.strip().splitlines() or ["it gives no reason"]
        raise InputError(*(f"sbatch refuses: {line}" for line in lines))
    return answer.stdout.strip().partition(";")[0]
