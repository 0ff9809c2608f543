"""What this machine can and cannot do for a sweep, in plain words, each found out by trying."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from sweep.errors import InputError
from sweep.machine import cache_folder, processor_name
from sweep.schema import RESULTS, ROW
from sweep.site import launch, probe, schedulers
from sweep.site.scheduler import Scheduler
from sweep.store import disk as disks
from sweep.store import table
from sweep.store.lease import BEAT, LEASE_MAX
from sweep.store.lock import only_run

GOOD, LIMIT, BAD = "good", "limit", "bad"  # LIMIT: a sweep can run all the same
HANGING_AFTER = 60.0  # seconds without a row: a probe starts within a few
LOOK_EVERY = 0.02  # seconds between looks at its rows
ROWS_WANTED = 64  # read back before the kill: several writes of every rank
WIDTH_GOOD = 4  # doubles that the processor takes at once: fewer are told as a limit
CACHE_BYTES = 50_000_000  # the kernel of the paper's chain takes 40 MB
FREE_BYTES_MIN = 1e9  # on a good disk: room for the rows of six million tasks


@dataclass(frozen=True)
class Examined:
    """One thing that was tried."""

    what: str
    verdict: str  # GOOD, LIMIT or BAD
    told: str  # in words; a key of `sweep doctor --json`


def examine(folder: Path) -> list[Examined]:
    """Try everything; leaves nothing behind. InputError where `folder` is none that can be written."""
    try:
        work = tempfile.TemporaryDirectory(prefix=".doctor-", dir=folder)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written: {error.strerror}; sweeps need a folder for their table"
        ) from None
    with work as name:
        place = Path(name)
        return [
            Examined("processor", *_processor()),
            Examined("kernel", *_cache()),
            Examined("disk", *disk(place)),
            Examined("locks", *_locks(place)),
            Examined("HDF5", *_hdf5()),
            Examined("one process", *_written(place, 1)),
            Examined("MPI", *_written(place, 2)),
            *map(scheduler, schedulers.ALL),
        ]


def can_run(findings: list[Examined]) -> bool:
    """Whether a sweep can run here, if only in one process."""
    return all(finding.verdict != BAD for finding in findings)


def as_text(answer: dict[str, Any]) -> str:
    """A line per finding, and what follows from them."""
    lines = [f"{each['verdict']:6}{each['what']:12} {each['told']}" for each in answer["findings"]]
    end = "a sweep can run here" if answer["can_run"] else "a sweep cannot run here: see the lines that begin with bad"
    return "\n".join([*lines, end])


def _processor() -> tuple[str, str]:
    """Name, cores and vector width of the processor."""
    flags = Path("/proc/cpuinfo").read_text().split() if Path("/proc/cpuinfo").exists() else []
    width = next((n for name, n in (("avx512f", 8), ("avx2", 4), ("sse2", 2)) if name in flags), 1)
    cores = len(os.sched_getaffinity(0))
    verdict = GOOD if width >= WIDTH_GOOD else LIMIT
    return verdict, f"{processor_name()}, {cores} cores for this process, vectors of {width}"


def _cache() -> tuple[str, str]:
    """Whether the kernel is compiled, and where it is kept."""
    folder = cache_folder()
    compiled = sum(1 for _ in folder.rglob("*.nbc")) if folder.is_dir() else 0
    parent = next(path for path in (folder, *folder.absolute().parents) if path.is_dir())
    try:
        with tempfile.TemporaryFile(dir=parent) as tried:
            os.posix_fallocate(tried.fileno(), 0, CACHE_BYTES)
    except OSError as error:
        if compiled:
            return LIMIT, f"compiled code in {folder}, where no more can be kept ({error.strerror})"
        why = f"({error.strerror}): every start compiles"
        return LIMIT, f"the compiled kernel cannot be kept in {folder} {why}; set NUMBA_CACHE_DIR"
    if not compiled:
        return LIMIT, f"not compiled yet: the first run takes a minute longer, then finds it in {folder}"
    return GOOD, f"compiled code in {folder}"


def disk(place: Path) -> tuple[str, str]:
    """Room and kind of file system."""
    free, kind = shutil.disk_usage(place).free, disks.kind_of(place)
    text = f"{kind}, {free / 1e9:.3g} GB free, {free / ROW.itemsize / 1e6:.3g} million rows"
    if disks.is_shared(place):
        who = "all ranks may write" if disks.is_coherent(place) else "over several nodes rank 0 writes for all"
        return LIMIT, f"{text}; shared with other machines: {who}, unless --writer says otherwise"
    return (GOOD if free > FREE_BYTES_MIN else LIMIT), text


def scheduler(asked: Scheduler) -> Examined:
    """Whether a scheduler takes jobs from here."""
    can_submit, text = asked.examine()
    return Examined(asked.name, GOOD if can_submit else LIMIT, text)


def _locks(place: Path) -> tuple[str, str]:
    try:
        with only_run(place / "lock"):
            told = "two runs cannot write one table: this node's by the file system's locks, those of other nodes by"
            return GOOD, f"{told} a lease beside the table, renewed every {BEAT:.0f} s, dead after {LEASE_MAX:.0f} s"
    except InputError as error:
        return BAD, str(error)


def _hdf5() -> tuple[str, str]:
    version = f"HDF5 {h5py.version.hdf5_version}, h5py {h5py.__version__}"
    if h5py.get_config().mpi:
        return GOOD, f"{version}, parallel: every rank can write its own rows (--writer mpio)"
    return LIMIT, f"{version}, serial: rank 0 writes for all (--writer gather); `make setup` builds a parallel one"


def _written(place: Path, ranks: int) -> tuple[str, str]:
    """Start ranks that write, kill them in the middle, read back."""
    writer = "mpio" if ranks > 1 and h5py.get_config().mpi else "gather"
    launcher = launch.mpirun() or shutil.which("mpiexec")
    if ranks > 1 and launcher is None:
        return LIMIT, "no mpirun beside this Python or in PATH: one process only"
    path = place / f"{ranks}.h5"
    try:
        table.create(path, probe.TASKS, {})
    except InputError:  # which asks for another -o
        return BAD, "the disk has no room for a small table"
    except OSError as error:
        return BAD, f"no table can be written: {error.strerror or error}"
    command = [] if ranks == 1 else [str(launcher), "-n", str(ranks)]
    with _started([*command, sys.executable, "-P", "-m", "sweep.site.probe", str(path), writer], place) as process:
        before = _wait_for_rows(path, process, place / "out")
    said = (place / "out").read_text().split(maxsplit=1)
    return _judge(path, ranks, before, said, (place / "err").read_text(errors="replace"))


def _judge(path: Path, ranks: int, before: np.ndarray, said: list[str], errors: str) -> tuple[str, str]:
    trouble = LIMIT if ranks > 1 else BAD
    if not len(before):
        last = (errors.strip().splitlines() or ["it hung"])[-1]
        return trouble, f"{ranks} rank{'s' * (ranks > 1)} started, and wrote nothing: {last}"
    if int(said[0]) != ranks:
        return trouble, f"mpirun belongs to another MPI: each of {ranks} ranks saw itself alone ({said[1].strip()})"
    if not _kept(path, before):
        return BAD, "rows that had been written were lost when the writers were killed; use another file system"
    who = "one process writes" if ranks == 1 else f"{ranks} ranks write one table with {said[1].strip()}"
    return GOOD, f"{who}; killed in the middle, all of {len(before)} rows seen before were there"


@contextmanager
def _started(command: list[str], place: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Start it in a process group of its own; at the end it is killed, whatever it is doing."""
    with (place / "out").open("wb") as out, (place / "err").open("wb") as err:
        ours = launch.without_launcher(os.environ)
        process = subprocess.Popen(command, stdout=out, stderr=err, env=ours, start_new_session=True)
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait(HANGING_AFTER)


def _wait_for_rows(path: Path, process: "subprocess.Popen[bytes]", out: Path) -> np.ndarray:
    """The numbers of the rows that another process sees finished, once the launcher has handed on what rank 0 says."""
    until = time.monotonic() + HANGING_AFTER
    while time.monotonic() < until and process.poll() is None:
        with table.reading(path) as file:
            ids = np.flatnonzero(table.finished(file))
        if len(ids) >= ROWS_WANTED and out.read_text().endswith("\n"):
            return ids
        time.sleep(LOOK_EVERY)
    return np.empty(0, np.int64)


def _kept(path: Path, ids: np.ndarray) -> bool:
    with table.reading(path) as file:
        rows: np.ndarray = file[RESULTS][()][ids]
    return rows.tobytes() == probe.rows_of(ids).astype(ROW).tobytes()
