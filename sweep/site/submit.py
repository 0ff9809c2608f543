"""`sweep submit`: write the script of a sweep and hand it to the scheduler, where its command is there."""

import math
import re
import shlex
import shutil
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sweep.errors import InputError, writing
from sweep.files import folder_problem, replacing, wrong_ending
from sweep.log import say
from sweep.plan.shard import SHARDS_MAX
from sweep.plan.spec import Spec, read_spec
from sweep.site import asking
from sweep.site.scheduler import Request, Scheduler
from sweep.site.scripts import AS_BYTES
from sweep.tell import report
from sweep.tell.text import duration

RANKS_MAX = 64  # unless the user asks for more: nobody takes half a cluster unasked
RANK_SECONDS_MIN = 600.0  # predicted work of each rank: with less, starting and compiling would take a large share
TIME_FACTOR, TIME_START = 2.0, 600.0  # of the predicted time; and seconds, for compiling and for opening files
TIME_MAX = 12 * 3600.0  # seconds, unless the user asks for more: what does not fit is queued again
ARRAY_JOB = "ARRAY_JOB"  # stands for the array's number before there is one


@dataclass(frozen=True)
class Order:
    """What a scheduler is to run, and the script that says so to it."""

    scheduler: Scheduler
    request: Request
    script: Path
    text: str
    merge: str  # of an array the shell command for afterwards; else empty

    def merge_job(self, array: str) -> list[str]:
        """The command that submits what follows the job `array`."""
        return self.scheduler.follow(self.request, array, self.merge)


def order(wish: Request, scheduler: Scheduler) -> Order:
    """The script for a sweep; InputError naming every problem. Writes nothing."""
    spec, text = read_spec(wish.spec)
    if spec.asked and wish.array:
        raise InputError("--array: a search has no shares: what it computes follows from its results")
    _check(wish, spec.tasks, scheduler)
    name = re.sub(r"[^\w.-]+", "-", spec.name).strip("-.") or "sweep"  # with a hyphen first it would be an option
    given = wish.table or Path(f"{name}.h5")
    if not given.name:
        raise InputError(f"--output: must name a file, got {str(wish.table)!r}")
    ranks, time = _size(wish, spec, text, scheduler)
    table, commands = given.absolute(), Path(sys.executable).parent.absolute()
    request = replace(
        wish, spec=wish.spec.absolute(), table=table, ranks=ranks, time=time, name=name, commands=commands
    )
    merge = ""
    if wish.array:
        shards = [str(shard_table(table, k, wish.array)) for k in range(1, wish.array + 1)]
        merge = shlex.join([str(commands / "sweep"), "merge", *shards, "-o", str(table)])
    return Order(scheduler, request, given.with_suffix(scheduler.ending), scheduler.script(request), merge)


def shard_table(table: Path, index: int, count: int) -> Path:
    """The name that every scheduler's script gives to the table of one shard."""
    return table.with_name(f"{table.name.removesuffix('.h5')}-{index}-of-{count}.h5")


def submit(ordered: Order) -> str:
    """Write the script, submit it if there is a scheduler; what was done, for people.

    InputError where the scheduler refuses.
    """
    command, script = ordered.scheduler.command, ordered.script
    is_new = _write(script, ordered.text)
    if shutil.which(command) is None:
        by_hand = shlex.join(ordered.scheduler.submit(script))
        text = f"wrote {script}; no {command} here: where there is one, run {by_hand}"
        return f"{text}\nand when all is done, {ordered.merge}" if ordered.merge else text
    try:
        job = _submitted(ordered.scheduler, ordered.scheduler.submit(script.absolute()))
    except InputError:
        if is_new:
            script.unlink()
        raise
    text = f"wrote {script}; submitted as job {job}"
    if not ordered.merge:
        return text
    try:
        last = _submitted(ordered.scheduler, ordered.merge_job(job))
    except InputError as error:
        raise InputError(*error.problems, f"{text}; when all of it is done, {ordered.merge}") from None
    return f"{text}; job {last} merges its shards when all have ended"


def rehearse(ordered: Order) -> str:
    """What `submit` would write and submit, as one shell script; the job that merges is a comment at its end."""
    script = ordered.text.rstrip("\n")
    if not ordered.merge:
        return script
    lines = shlex.join(ordered.merge_job(ARRAY_JOB)).splitlines()  # a name may hold a line's end
    return "\n".join(
        [script, "", "# When all of the array have ended, their tables are merged by", *(f"#   {x}" for x in lines)]
    )


def _check(wish: Request, tasks: int, scheduler: Scheduler) -> None:
    problems = [problem] if wish.table and (problem := wrong_ending(wish.table)) else []
    if wish.table and (problem := folder_problem(wish.table)):  # the script goes there too
        problems.append(f"--output: {problem}")
    if wish.ranks is not None and wish.ranks < 1:
        problems.append(f"--ranks: must be at least 1, got {wish.ranks}")
    if wish.array is not None and not 1 <= wish.array <= min(SHARDS_MAX, tasks):
        problems.append(f"--array: must be from 1 to {min(SHARDS_MAX, tasks)} for this sweep, got {wish.array}")
    for option in wish.others:
        if rule := scheduler.option_problem(option):
            problems.append(f"--{scheduler.command}: {rule}, got {option!r}")
    for name in ("partition", "account"):
        if (value := getattr(wish, name)) is None:
            continue
        if not scheduler.has_places:
            problems.append(f"--{name}: {scheduler.name} knows none, got {value!r}")
        elif not re.fullmatch(r"[\w.,@:+-]+", value):
            problems.append(f"--{name}: must be a name, got {value!r}")
    if wish.time is not None:
        try:
            scheduler.seconds_of(wish.time)
        except ValueError as error:
            problems.append(f"--time: {error}")
    if problems:
        raise InputError(*problems)


def _size(wish: Request, spec: Spec, text: str, scheduler: Scheduler) -> tuple[int, str]:
    """Ranks and time limit, from the plan where not asked for."""
    if wish.ranks is not None and wish.time is not None:
        return wish.ranks, wish.time
    plan: dict[str, Any] = report.plan(spec, text, wish.spec.resolve().parent)
    work, longest, shards = 3600 * plan["core_hours"], plan["longest_task_s"], wish.array or 1
    most = min(RANKS_MAX, spec.tasks, math.floor(work / RANK_SECONDS_MIN))
    ranks = wish.ranks or (1 if wish.array else max(1, most))
    wall = max(work / (ranks * shards), longest)
    time = wish.time or scheduler.time_of(min(TIME_MAX, TIME_FACTOR * wall + TIME_START))
    if longest > scheduler.seconds_of(time):
        say(f"--time: {time} is shorter than the longest task, which is predicted to take {duration(longest)}")
    return ranks, time


def _write(script: Path, text: str) -> bool:
    """Whether there was none; a script that was edited since is not overwritten, and half of one is never left."""
    with writing(script):
        if script.exists():
            if script.read_text(*AS_BYTES) != text:
                told = "exists and says something else; submit it by hand, remove it, or give another -o"
                raise InputError(f"{script}: {told}")
            return False
        with replacing(script) as new:
            new.write_text(text, *AS_BYTES)
    return True


def _submitted(scheduler: Scheduler, command: list[str]) -> str:
    """The job's number."""
    try:
        answer = asking.called(command)
    except OSError as error:
        raise InputError(f"{command[0]}: cannot be run: {error.strerror}") from None
    if answer.returncode:
        lines = answer.stderr.strip().splitlines() or ["it gives no reason"]
        raise InputError(*(f"{command[0]} refuses: {line}" for line in lines))
    return scheduler.number_in(answer.stdout)
