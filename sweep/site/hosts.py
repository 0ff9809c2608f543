"""Hosts without a scheduler that ssh reaches: mpirun starts the ranks there, and a script of ours starts it again."""

import re
import shlex
import shutil
from collections.abc import Mapping
from pathlib import Path

from sweep.site import scripts
from sweep.site.scheduler import Request, Scheduler

NO_LIMIT = "none"


class Hosts(Scheduler):
    """What `Scheduler` asks. There is no time limit, and a job is the process that runs the script."""

    name, command, ending = "ssh", "ssh", ".sh"
    option_help, option_example = "a host and how many ranks it gets (default: localhost)", "node1:16"
    has_limit, has_places = False, False
    automatic = False  # ssh is everywhere: no sign that hosts wait for work

    def job(self, environment: Mapping[str, str]) -> str:
        return ""

    def end(self, environment: Mapping[str, str]) -> float | None:
        return None

    def seconds_of(self, time: str) -> float:
        if time != NO_LIMIT:
            raise ValueError(f"must be {NO_LIMIT}: hosts without a scheduler have no limit, got {time!r}")
        return float("inf")

    def time_of(self, seconds: float) -> str:
        return NO_LIMIT

    def option_problem(self, option: str) -> str:
        return "" if re.fullmatch(r"[\w.-]+(:[1-9][0-9]*)?", option) else "must be a host, NAME or NAME:RANKS"

    def script(self, request: Request) -> str:
        values = scripts.values_of(request) | {"hosts": ",".join(request.others or ("localhost",))}
        return scripts.filled("hosts.sh", [], values)

    def submit(self, script: Path) -> list[str]:
        return _in_background(f"bash {shlex.quote(str(script))}", script.with_suffix(".log"))

    def follow(self, request: Request, job: str, then: str) -> list[str]:
        log = request.table.with_suffix(".merge.log") if request.table else Path("merge.log")
        return _in_background(f"while kill -0 {job} 2>/dev/null; do sleep 5; done; {then}", log)

    def examine(self) -> tuple[bool, str]:
        if shutil.which("ssh") is None:
            return False, "no ssh"
        return True, "hosts that ssh reaches can be used: sweep submit --scheduler ssh --ssh=HOST:RANKS ..."


def _in_background(command: str, log: Path) -> list[str]:
    """A command that starts another one, which outlives it, and prints its process."""
    return ["bash", "-c", f"setsid nohup bash -c {shlex.quote(command)} >>{shlex.quote(str(log))} 2>&1 & echo $!"]
