"""Waiting for a run that is under way in other processes; with a limit, so that one that hangs fails."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from sweep.errors import InputError
from sweep.store.lock import only_run
from sweep.tell import report

WAIT = 120.0  # seconds; a run that has finished nothing by then hangs


def wait_for_rows(path: Path, process: "subprocess.Popen[str]", at_least: int = 1) -> int:
    """Wait until so many rows are done; how many."""
    until = time.monotonic() + WAIT
    while time.monotonic() < until:
        assert process.poll() is None, "the run ended before it could be stopped"
        try:
            done = int(report.status(path)["done"])
        except InputError:  # it is not there yet
            done = 0
        if done >= at_least:
            return done
        time.sleep(0.02)
    raise AssertionError(f"fewer than {at_least} rows were finished")


def wait_for(what: Callable[[], bool]) -> None:
    """Wait until it is so."""
    until = time.monotonic() + WAIT
    while not what():
        assert time.monotonic() < until, "it did not come"
        time.sleep(0.02)


def wait_for_the_lock(path: Path) -> None:
    """Ranks outlive a killed mpirun by a moment: the run is over when its lock is free."""
    until = time.monotonic() + WAIT
    while time.monotonic() < until:
        try:
            with only_run(path):
                return
        except InputError:
            time.sleep(0.05)
    raise AssertionError("ranks are left over")
