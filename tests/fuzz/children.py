"""Cases in a child process: one that crashes or hangs costs itself only, and is counted."""

import contextlib
import multiprocessing
import os
import resource
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from tests.fuzz.judge import Told

Case = Callable[[np.random.Generator, Path], Told]
Tell = Callable[[str], None]
Seed = tuple[int, ...]
HANG, CRASH = "hangs", "crashes"
PATIENCE = 60.0  # seconds of one case, on a machine that may be busy
MEMORY = 2 << 30  # bytes that the cases of one child may take beyond what it begins with
AT_ONCE = 500  # cases of one child
_FORK = multiprocessing.get_context("fork")  # what is imported and compiled need not be again


def run(case: Case, seed: Seed, first: int, last: int, count: Counter[str], tell: Tell) -> None:
    """Cases first..last-1, counted by their outcome; `tell` hears of every broken rule."""
    while first < last:
        first = _one_child(case, seed, first, min(last, first + AT_ONCE), count, tell)


def _one_child(case: Case, seed: Seed, first: int, last: int, count: Counter[str], tell: Tell) -> int:
    """As far as one child comes; the next case."""
    ours, theirs = _FORK.Pipe(duplex=False)
    child = _FORK.Process(target=_work, args=(case, seed, first, last, theirs), daemon=True)
    child.start()
    theirs.close()
    outcome, why = "", ""
    try:
        while first < last:
            if not ours.poll(PATIENCE):
                outcome = HANG
                break
            outcome, why = ours.recv()
            count[outcome] += 1
            if why:
                tell(f"case {first}: {outcome}: {why}")
            first, outcome = first + 1, ""
    except EOFError:
        outcome = CRASH
    if outcome:
        child.kill()
    child.join()
    if outcome:
        count[outcome] += 1
        tell(f"case {first}: {outcome} (exit status {child.exitcode})")
        first += 1
    return first


def _work(case: Case, seed: Seed, first: int, last: int, pipe: Connection) -> None:
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, size + MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    home = Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        for number in range(first, last):
            folder = home / "case"
            folder.mkdir()
            pipe.send(case(np.random.default_rng([*seed, number]), folder))
            os.chdir("/")
            shutil.rmtree(folder)
    finally:
        with contextlib.suppress(OSError):
            shutil.rmtree(home)
