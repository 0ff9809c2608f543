"""Commands that can be stopped while they go on: in a process forked off this one, or on several ranks."""

import contextlib
import importlib
import os
import secrets
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

import kernel
from sweep import cli
from tests.chaos import _defunct, ranks_of
from tests.conftest import BIN, clean_environment

# What the commands import when they need it.
MODULES = (
    "sweep.conduct",
    "sweep.guest",
    "sweep.plan.spec",
    "sweep.store.merge",
    "sweep.tell.audit",
    "scipy.stats.qmc",
)
LIMIT = 200.0  # seconds after which a command hangs
LOOK_EVERY = 0.005
MARK = "SWEEP_HISTORY"  # in the environment of whatever ranks start, by which they are known


def load() -> None:
    """What all commands share, once: modules, and the compiled kernel with each of its integrators."""
    for name in MODULES:
        importlib.import_module(name)
    chains = {"N": [5, 50], "zeta_T": [1e-4, 0.3], "M_over_M0": 1.0, "V_over_V0": 1.0}
    for model, observe in (
        (kernel.Model(), ("ke",)),
        (kernel.Model(kernel.Bistable(4.5, 6.0), site=0.4), ("ke", "wall_force")),
    ):
        for accuracy in (1e-2, 1e-4, 1e-6):
            kernel.measure(chains, observe=observe, model=model, accuracy=accuracy)
        kernel.measure(chains, observe=observe, model=model, method="rk45", rtol=1e-4)


class Hung(Exception):  # noqa: N818 # what the program finds, not what went wrong in it
    """A command that does not end."""


class Told(NamedTuple):
    """How a command ended: a negative status is the signal that did it."""

    status: int
    out: str
    err: str


class Command:
    """One `sweep` command under way; output goes to files in `scratch`."""

    def __init__(self, folder: Path, scratch: Path, arguments: list[str], ranks: int = 1) -> None:
        self._out, self._err = (scratch / f"{secrets.token_hex(4)}.{name}" for name in ("out", "err"))
        self.ranks, self._mark, self._popen, self._status = ranks, secrets.token_hex(8), None, None
        self._told: Told | None = None
        self._seen = set[Path]()  # processes of its ranks, while they are there
        self.line = f"{f'mpirun -n {ranks} ' if ranks > 1 else ''}sweep {' '.join(arguments)}"
        if ranks == 1:
            self.pid = forked(lambda: cli.main(arguments), folder, self._out, self._err)
            return
        command = [str(BIN / "mpirun"), "-n", str(ranks), sys.executable, "-P", "-m", "sweep", *arguments]
        with self._out.open("w") as out, self._err.open("w") as err:
            self._popen = subprocess.Popen(
                command,
                cwd=folder,
                env=clean_environment() | {MARK: self._mark},
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                start_new_session=True,
            )
        self.pid = self._popen.pid

    def goes_on(self) -> bool:
        """Whether it has not ended."""
        if self._popen is not None:
            return self._popen.poll() is None
        if self._status is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self._status = os.waitstatus_to_exitcode(status) if pid else None
        return self._status is None

    def wait(self) -> Told:
        """How it ended, once everything that it started has."""
        if self._told is not None:
            return self._told
        until = time.monotonic() + LIMIT
        while self.goes_on() or self._is_left():
            if time.monotonic() > until:
                self.kill("all", np.random.default_rng())
                raise Hung(f"{self.line}: has not ended in {LIMIT:.0f} s\n{self._err.read_text()}")
            time.sleep(LOOK_EVERY)
        status = self._popen.returncode if self._popen is not None else self._status
        assert status is not None
        self._told = Told(status, *(each.read_text() if each.exists() else "" for each in (self._out, self._err)))
        for each in (self._out, self._err):
            each.unlink(missing_ok=True)
        return self._told

    def kill(self, victim: str, rng: np.random.Generator) -> None:
        """SIGKILL for a worker, the master, the launcher, or all of them."""
        ranks = ranks_of(self.pid) if self.ranks > 1 else {}
        workers = [pid for rank, pid in ranks.items() if rank > 0]
        chosen = {"worker": workers, "master": [ranks[0]] if 0 in ranks else [], "launcher": [self.pid]}
        there = chosen.get(victim)
        for pid in [int(rng.choice(there))] if there else [self.pid, *ranks.values()]:
            _send(pid, signal.SIGKILL)

    def stop(self) -> None:
        """SIGTERM."""
        _send(self.pid, signal.SIGTERM)

    def _is_left(self) -> bool:
        """Whether a process of it is there that its launcher has left behind."""
        if self.ranks == 1:
            return False
        mark = f"{MARK}={self._mark}".encode()
        for folder in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if mark in (folder / "environ").read_bytes().split(b"\0"):
                    self._seen.add(folder)
        # One that is dying shows no environment any more, and holds its locks still.
        self._seen = {folder for folder in self._seen if not _defunct(int(folder.name))}
        return bool(self._seen)


def _send(pid: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, number)


def forked(command: Callable[[], int], folder: Path, out: Path, err: Path) -> int:
    """A process that has everything loaded, as of tests.forked, and is that command; its number."""
    sys.stdout.flush()
    sys.stderr.flush()
    if pid := os.fork():
        return pid
    status = 70
    try:
        os.chdir(folder)
        for number, name, how in (
            (0, os.devnull, os.O_RDONLY),
            (1, str(out), os.O_WRONLY | os.O_CREAT),
            (2, str(err), os.O_WRONLY | os.O_CREAT),
        ):
            os.dup2(os.open(name, how), number)
        status = command()
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 1
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status)
