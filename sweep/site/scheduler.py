"""What the sweep asks of a scheduler. Each scheduler is one object in one file, and `schedulers.ALL` names them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol


@dataclass(frozen=True)
class Request:
    """A sweep as one job, or as an array of jobs that each compute a shard. A scheduler sees it without None in the
    first fields, paths absolute: `sweep.site.submit.order` takes from the plan what the user left open.
    """

    spec: Path
    table: Path | None = None  # in an array, job K of N writes sweep.site.submit.shard_table(table, K, N)
    ranks: int | None = None  # processes of each job
    time: str | None = None  # limit of each job, as the scheduler writes it
    array: int | None = None  # how many jobs; None: no array
    partition: str | None = None
    account: str | None = None
    others: tuple[str, ...] = ()  # further options of the scheduler's submit command
    writer: str = "auto"  # who writes rows, as `sweep run --writer` takes it
    name: str = ""
    commands: Path = Path()  # the folder of the command `sweep`, and of mpirun where the environment has its own

    @property
    def places(self) -> dict[str, str]:
        """Partition and account, where they are given."""
        return {name: text for name in ("partition", "account") if (text := getattr(self, name))}


class Scheduler(Protocol):
    """One scheduler. What a scheduler can do without has a default here."""

    name: str  # for people
    command: str  # submits a script; `sweep submit` has an option of that name, for further options of the command
    option_help: str = "any other option"  # what such an option is
    option_example: str = "--name=value"
    ending: str  # of the script's file name, with the dot
    automatic: bool = True  # whether its command is a sign that it is in use here
    has_limit: bool = True  # whether its jobs end after a time
    has_places: bool = True  # whether it knows partitions and accounts
    launcher: str = ""  # the scheduler's own counterpart of mpirun, and how to name the MPI that it shall start
    size_variable: str = ""  # the environment variable in which it gives every process their number
    rank_variable: str = ""  # and in which it gives every process its rank

    def job(self, environment: Mapping[str, str]) -> str:
        """The job that this process belongs to, as its users name it; empty outside of a job."""

    def end(self, environment: Mapping[str, str]) -> float | None:
        """When the scheduler ends this job, in seconds since 1970; None outside of a job, or without a limit."""

    def idle(self, environment: Mapping[str, str]) -> str:
        """For the log of one process without a launcher: which of the job's processors it leaves idle; or empty."""
        return ""

    def seconds_of(self, time: str) -> float:
        """A time limit as the scheduler writes it; ValueError with the rule where it is not one."""

    def time_of(self, seconds: float) -> str:
        """The same the other way round, not below."""

    def option_problem(self, option: str) -> str:
        """The rule that a further option of the submit command breaks; empty where it breaks none."""
        return ""

    def script(self, request: Request) -> str:
        """The script of a job that stops before its limit and is queued again while `sweep run` exits with 75."""

    def submit(self, script: Path) -> list[str]:
        """The command that submits the script."""

    def follow(self, request: Request, job: str, then: str) -> list[str]:
        """The command that submits the shell command `then`, to run once all of the array `job` has ended."""

    def number_in(self, answer: str) -> str:
        """The job's number, in what the submit command prints."""
        return answer.strip()

    def examine(self) -> tuple[bool, str]:
        """For `sweep doctor`: whether jobs can be submitted from here now, and in words why (not)."""
