"""Kills sweeps and damages their tables, and counts what is lost: `python -m tests.chaos [--kills N] [--seed S]`.

A row counts as reported done once another process has read it, sealed, from the table. SIGKILL hits a worker, the
master, mpirun or all of them at once, at a random instant of a run that creates a table or resumes one; every table is
killed until it is complete and then compared, bit for bit, with one that was left in peace. Damage is a flipped bit or
a truncation at a random place of a complete table; the same sweep must find it and end in the same table.

Exit status 1 where anything was lost, torn, unreadable or different.
"""

import argparse
import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import h5py
import numpy as np

from sweep.errors import DamagedTableError, InputError
from sweep.schema import RESULTS, RUN_COLUMNS
from sweep.store import table
from sweep.store.lock import only_run
from tests import shared_memory

BIN = Path(sys.executable).parent
SPEC = """
name = "chaos"
[grid]
N         = { linear = [20, 40], points = 21 }
zeta_T    = [1e-4, 1e-3]
M_over_M0 = [0.5, 2]
V_over_V0 = { log = [0.3, 3], points = 10 }
[accuracy]
method = "rk45"
rtol = 1e-4
"""
RANKS, WAIT = 3, 120.0  # seconds
VICTIMS = ("worker", "master", "mpirun", "all")
WRITERS = ("mpio", "gather") if h5py.get_config().mpi else ("gather",)
PIPES = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
COUNTED = ("killed", "while creating", "rows reported", "lost", "torn", "unreadable", "different")
FOUND = ("damaged", "found and repaired", "nothing to repair", "different")


def start(folder: Path, writer: str, *more: str) -> "subprocess.Popen[str]":
    """A run in a process group of its own."""
    command = [BIN / "mpirun", "-n", str(RANKS), BIN / "sweep", "run", "spec.toml", "-o", "t.h5", "--writer", writer]
    return subprocess.Popen([*command, *more], cwd=folder, **PIPES)


def ranks_of(launcher: int) -> dict[int, int]:
    """Rank to process, of those that mpirun's process group holds by now."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError, ValueError):  # it has ended meanwhile
            if os.getpgid(int(folder.name)) == launcher or _grandparent(folder) == launcher:
                for text in (folder / "environ").read_bytes().split(b"\0"):
                    if text.startswith(b"PMI_RANK="):
                        found[int(text[9:])] = int(folder.name)
    return found


def _grandparent(folder: Path) -> int:
    def parent(pid: str) -> str:
        return Path("/proc", pid, "stat").read_text().rpartition(")")[2].split()[1]

    return int(parent(parent(folder.name)))


def finished_rows(path: Path) -> dict[int, bytes]:
    """What a reader is told is done; empty while there is no table."""
    if not path.exists():
        return {}
    with table.reading(path) as file:
        ids, rows = np.flatnonzero(table.finished(file)), file[RESULTS][()]
    return {int(i): rows[i].tobytes() for i in ids}


def kill(process: "subprocess.Popen[str]", victim: str, rng: np.random.Generator) -> None:
    """SIGKILL to the victim; the rest of the job must then end by itself, in time."""
    ranks = ranks_of(process.pid)
    workers = [pid for rank, pid in ranks.items() if rank > 0]
    chosen = {"worker": workers, "master": [ranks[0]] if 0 in ranks else [], "mpirun": [process.pid]}.get(victim, [])
    # All of them too where the victim is not there yet.
    pids = [int(rng.choice(chosen))] if chosen else [process.pid, *ranks.values()]
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    process.communicate(timeout=WAIT)
    until = time.monotonic() + WAIT
    while any(Path(f"/proc/{pid}").exists() and not _defunct(pid) for pid in ranks.values()):
        assert time.monotonic() < until, "ranks are left over"
        time.sleep(0.01)


def _defunct(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    return True


def one_kill(
    folder: Path, writer: str, victim: str, life: float, rng: np.random.Generator, count: Counter[str]
) -> bool:
    """Start, wait, kill, look; whether the run was still going on when it was hit."""
    path = folder / "t.h5"
    created = path.exists()
    process = start(folder, writer)
    time.sleep(float(rng.uniform(0.0, life)))
    reported = finished_rows(path)
    creating = not created and not path.exists()
    alive = process.poll() is None
    kill(process, victim, rng)
    if not alive:
        return False
    try:
        after = finished_rows(path)
    except InputError:
        count["unreadable"] += 1
        return True
    count.update({"killed": 1, "while creating": int(creating), "rows reported": len(reported)})
    count["lost"] += len(reported.keys() - after.keys())
    count["torn"] += sum(after.get(i, row) != row for i, row in reported.items())
    return True


def content(path: Path) -> bytes:
    """The bits that must not depend on what happened."""
    with h5py.File(path, "r") as file:
        rows = file[RESULTS][()]
    return b"".join(rows[name].tobytes() for name in rows.dtype.names if name not in RUN_COLUMNS)


def complete(folder: Path, writer: str, *more: str) -> tuple[int, str]:
    """Run to the end; exit status and log."""
    process = start(folder, writer, *more)
    _, log = process.communicate(timeout=2 * WAIT)
    return process.returncode, log


def kills(
    whole: bytes, folder: Path, life: float, count: dict[tuple[str, str], Counter[str]], wanted: int, rng
) -> None:  # type: ignore[no-untyped-def]
    """Kill until `wanted` runs were hit, table after table."""
    hit = 0
    while hit < wanted:
        writer = WRITERS[int(rng.integers(len(WRITERS)))]
        (folder / "t.h5").unlink(missing_ok=True)
        victim = VICTIMS[0]
        for _ in range(4):
            victim = VICTIMS[int(rng.integers(len(VICTIMS)))]
            hit += one_kill(folder, writer, victim, life, rng, count[writer, victim])
        status, _ = complete(folder, writer)
        count[writer, victim]["different"] += status != 0 or content(folder / "t.h5") != whole


def damages(whole: bytes, folder: Path, sound: Path, count: Counter[str], wanted: int, rng) -> None:  # type: ignore[no-untyped-def]
    """Flip a bit, or cut the end off, and let the same sweep find it."""
    path = folder / "t.h5"
    for i in range(wanted):
        shutil.copy(sound, path)
        (folder / "t.h5.damaged").unlink(missing_ok=True)
        place = int(rng.integers(path.stat().st_size))
        if i % 4 == 3:
            os.truncate(path, place)
        else:
            raw = bytearray(path.read_bytes())
            raw[place] ^= 1 << int(rng.integers(8))
            path.write_bytes(raw)
        try:
            damaged = len(finished_rows(path)) < len(finished_rows(sound))
        except DamagedTableError:
            damaged = True
        status, log = complete(folder, WRITERS[i % len(WRITERS)])
        if status == 2 and "--repair" in log:
            status, log = complete(folder, WRITERS[i % len(WRITERS)], "--repair")
        traces = place == 0 and i % 4 == 3  # nothing is left of a file cut to nothing
        same = traces or (status == 0 and content(path) == whole)
        count.update({"damaged": 1, "different": not same})
        count["found and repaired" if damaged else "nothing to repair"] += same


def main() -> int:
    """Print what was counted; the exit status."""
    parser = argparse.ArgumentParser(prog="tests.chaos", description=__doc__)
    parser.add_argument("--kills", type=int, default=200, metavar="N")
    parser.add_argument("--damages", type=int, metavar="N", help="default: half as many")
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    args = parser.parse_args()
    rng = np.random.default_rng(args.seed)
    count = {(writer, victim): Counter[str]() for writer in WRITERS for victim in VICTIMS}
    damage: Counter[str] = Counter()
    with shared_memory.cleared(), tempfile.TemporaryDirectory() as name:
        folder, sound = Path(name), Path(name, "sound.h5")
        (folder / "spec.toml").write_text(SPEC)
        assert complete(folder, WRITERS[0])[0] == 0  # compiles
        (folder / "t.h5").unlink()
        began = time.monotonic()
        assert complete(folder, "gather")[0] == 0
        life = time.monotonic() - began  # of a run that is left in peace
        (folder / "t.h5").rename(sound)
        whole = content(sound)
        kills(whole, folder, life, count, args.kills, rng)
        damages(whole, folder, sound, damage, args.kills // 2 if args.damages is None else args.damages, rng)
        with only_run(folder / "t.h5"):
            pass  # nobody is left who writes
    print(f"{'writer':8}{'victim':8}" + "".join(f"{name:>16}" for name in COUNTED))
    for (writer, victim), counted in count.items():
        print(f"{writer:8}{victim:8}" + "".join(f"{counted[name]:16}" for name in COUNTED))
    print("\n" + "   ".join(f"{damage[name]} {name}" for name in FOUND))
    bad = sum(counted[name] for counted in count.values() for name in ("lost", "torn", "unreadable", "different"))
    return int(bad + damage["different"] > 0)


if __name__ == "__main__":
    sys.exit(main())
