"""A sweep of 1e8 tasks: how soon it starts, what rank 0 holds, how soon it is told and resumed.

    python -m tests.large [--seconds 60] [--folder /var/tmp] [--keep]

Starts it on two ranks, stops it by SIGINT after so many seconds, asks `sweep status` and `analysis best`, resumes it
and stops it again. The table takes 16 GB in the folder and is removed in the end. The kernel must be compiled already.
Beside the figures stand those of what is promised: start and answers within a minute, 1 GB on rank 0.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from sweep.errors import InputError
from sweep.store import table
from tests.measured import keep

BIN = Path(sys.executable).parent
SPEC = """
name = "large"
[grid]
N         = { linear = [5, 104], points = 100 }
zeta_T    = { log = [1e-5, 1e-2], points = 100 }
M_over_M0 = { log = [0.1, 10], points = 100 }
V_over_V0 = { log = [0.1, 10], points = 100 }
[accuracy]
target = 1e-1
certify = false
"""
LOOK_EVERY = 0.2  # seconds
STOP_MAX, ANSWER_MAX = 120.0, 600.0  # seconds for a run to stop, for a command to answer
PROMISED_SECONDS, PROMISED_GB = 60.0, 1.0


def finished(path: Path, run: int) -> int:
    """Rows that the run of this number (from 0) has finished, as the table's list of runs tells."""
    try:
        with table.reading(path) as file:
            runs = table.runs(file)
    except InputError:  # not there yet
        return 0
    return int(runs["left_at_start"][run] - runs["left"][run]) if len(runs) > run else 0


def peak(path: Path) -> float:
    """The most memory that rank 0 of the run that writes this table has held so far, in GB; 0 where there is none."""
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            first = b"PMI_RANK=0" in (process / "environ").read_bytes().split(b"\0")
            if first and str(path).encode() in words:
                lines = (process / "status").read_text().splitlines()
                return max(1e-6 * float(line.split()[1]) for line in lines if line.startswith("VmHWM"))
        except (OSError, ValueError):  # it has ended meanwhile
            continue
    return 0.0


def run(spec: Path, path: Path, number: int, seconds: float) -> tuple[float, float, int]:
    """Run for so long, then stop: seconds to the first row that is told, peak memory of rank 0 in GB, rows."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PMI")}
    command = [str(BIN / "mpirun"), "-n", "2", str(BIN / "sweep"), "run", str(spec), "-o", str(path)]
    start, first, most = time.monotonic(), float("nan"), 0.0
    process = subprocess.Popen(command, env=environment)
    while process.poll() is None and time.monotonic() - start < seconds:
        time.sleep(LOOK_EVERY)
        most = max(most, peak(path))
        if first != first and finished(path, number):
            first = time.monotonic() - start
    process.send_signal(signal.SIGINT)
    while process.poll() is None and time.monotonic() - start < seconds + STOP_MAX:
        time.sleep(LOOK_EVERY)
        most = max(most, peak(path))
    process.kill()
    process.wait()
    return first, most, finished(path, number)


def answer(*command: str) -> float:
    """Seconds that a command takes."""
    start = time.monotonic()
    subprocess.run([str(BIN / command[0]), *command[1:]], check=True, stdout=subprocess.DEVNULL, timeout=ANSWER_MAX)
    return time.monotonic() - start


def measured(folder: Path, seconds: float) -> Iterator[tuple[str, float, float]]:
    """What, how much, and how much is promised at most."""
    spec, path = folder / "large.toml", folder / "large.h5"
    spec.write_text(SPEC)
    for number, name in enumerate(("started", "resumed")):
        first, most, rows = run(spec, path, number, seconds)
        yield f"{name}: s to the first row told", first, PROMISED_SECONDS
        yield f"{name}: GB on rank 0", most, PROMISED_GB
        yield f"{name}: rows in {seconds:g} s", rows, float("inf")
        yield f"{name}, stopped: s of sweep status", answer("sweep", "status", str(path)), PROMISED_SECONDS
    yield "s of analysis best", answer("analysis", "best", str(path), "-o", str(folder / "b.png")), float("inf")


def main() -> int:
    """Measure and print; exit status 1 where a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--folder", type=Path, default=Path("/var/tmp"))
    parser.add_argument("--keep", action="store_true", help="for the documentation")
    args = parser.parse_args()
    rows, broken = [], False
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        for what, much, most in measured(Path(folder), args.seconds):
            told = f"{much:.3g}" if much < 1000 else f"{much:.0f}"
            print(f"{what:40} {told}", flush=True)
            rows.append({"1e8 tasks on two ranks": what, "measured": told})
            broken |= not 0 < much <= most
    if args.keep:
        keep("large", rows, "16 GB table, two loaded cores")
    return int(broken)


if __name__ == "__main__":
    sys.exit(main())
