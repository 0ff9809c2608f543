"""Runs commands in processes forked off one that has their modules and the compiled kernel loaded.

What an interpreter does before the first line of `sweep`, over a second, is done once instead of hundreds of times. The
command is the installed script, in a process with a folder, output and exit status of its own. Who wants ranks, another
environment, or to kill what was started takes an interpreter of its own (tests.conftest).
"""

import gc
import json
import os
import runpy
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any


class Forks:
    """The process that forks; environment: its own, and that of all that it forks."""

    def __init__(self, environment: dict[str, str]) -> None:
        pipe, command = subprocess.PIPE, [sys.executable, __file__]
        self.server = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, env=environment)

    def run(self, command: list[str], folder: Path, limit: int) -> "subprocess.CompletedProcess[str]":
        """As subprocess.run of a Python script with its arguments; subprocess.TimeoutExpired after `limit` seconds."""
        with NamedTemporaryFile() as out, NamedTemporaryFile() as err:
            asked = {"command": command, "folder": str(folder), "out": out.name, "err": err.name, "limit": limit}
            print(json.dumps(asked), file=self.server.stdin, flush=True)
            assert self.server.stdout
            status = int(self.server.stdout.readline())
            if status == -signal.SIGALRM:
                raise subprocess.TimeoutExpired(command, limit)
            return subprocess.CompletedProcess(command, status, out.read().decode(), err.read().decode())


def _forked() -> Iterator[dict[str, Any]]:
    """A process for every line that is read; gives, in that process, what the line asks for."""
    for line in sys.stdin:
        child = os.fork()
        if not child:
            yield json.loads(line)
            return
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def _serve() -> None:
    """Load what a sweep of the paper's chain needs, and become whatever is asked for."""
    import kernel
    import sweep.cli
    import sweep.conduct
    import sweep.tell.report  # noqa: F401

    kernel.ke_ratio(5, 0.0, 1.0, 1.0)
    gc.freeze()  # else each process that ends would look through, and so copy, all that it shares
    for asked in _forked():
        os.chdir(asked["folder"])
        signal.alarm(asked["limit"])
        for number, name, how in (
            (0, os.devnull, os.O_RDONLY),
            (1, asked["out"], os.O_WRONLY),
            (2, asked["err"], os.O_WRONLY),
        ):
            os.dup2(os.open(name, how), number)
        sys.argv, sys.path[0] = asked["command"], str(Path(asked["command"][0]).parent)
        runpy.run_path(sys.argv[0], run_name="__main__")


if __name__ == "__main__":
    _serve()
