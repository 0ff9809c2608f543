"""How much of its time a process computes that joined a run, beside one that was started with it.

    python -m tests.joining [--spec SPEC] [--ranks 1] [--keep]

Twice the same sweep: on one rank more, and on so many ranks that one process joins. Told are the shares of the time in
which the processes computed, by the rows' own seconds: of the process that joined from its arrival to the end of the
run. What else the machine does makes both times longer and leaves the shares.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from sweep.schema import RESULTS
from sweep.store import mailbox, table
from tests.measured import keep
from tests.scaling import BIN, LIMIT, SPEC

LOOK_EVERY = 0.02  # seconds


def started(spec: Path, path: Path, ranks: int) -> "subprocess.Popen[bytes]":
    """The sweep into a new table."""
    launcher = [str(BIN / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
    return subprocess.Popen(
        [*launcher, str(BIN / "sweep"), "run", str(spec), "-o", str(path)], stderr=subprocess.DEVNULL
    )


def together(spec: Path, path: Path, ranks: int) -> float:
    """The least busy share of ranks that were started together."""
    started(spec, path, ranks).wait(LIMIT)
    with table.reading(path) as file:
        return float(table.runs(file)[-1]["least_busy_share"])


def joined(spec: Path, path: Path, ranks: int) -> tuple[float, float, int]:
    """The busy share of a process that joined, that of the least busy rank of the run, rows of the former."""
    run, folder = started(spec, path, ranks), mailbox.folder_of(path)
    while not (folder / mailbox.RUN).exists() and run.poll() is None:
        time.sleep(LOOK_EVERY)
    guest = subprocess.Popen([str(BIN / "sweep"), "join", str(path)], stdout=subprocess.DEVNULL)
    while not mailbox.names(folder, mailbox.GUEST) and run.poll() is None:
        time.sleep(LOOK_EVERY)
    arrived = time.monotonic()
    while folder.exists() and run.poll() is None:
        time.sleep(LOOK_EVERY)
    there = time.monotonic() - arrived
    run.wait(LIMIT)
    guest.wait(LIMIT)
    with table.reading(path) as file:
        rows, last = file[RESULTS][()], table.runs(file)[-1]
    its = rows[rows["rank"] == ranks]
    return float(its["seconds"].sum()) / there, float(last["least_busy_share"]), len(its)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spec", type=Path)
    parser.add_argument("--ranks", type=int, default=1, help="of the run that is joined")
    parser.add_argument("--keep", action="store_true", help="for the documentation")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        spec = args.spec or Path(folder, "spec.toml")
        if args.spec is None:
            spec.write_text(SPEC)
        beside = together(spec, Path(folder, "together.h5"), args.ranks + 1)
        busy, host, rows = joined(spec, Path(folder, "joined.h5"), args.ranks)
    told = {
        f"least busy of {args.ranks + 1} ranks started together": beside,
        "process that joined, from its arrival to the end": busy,
        "least busy rank of the run that it joined": host,
    }
    for name, share in told.items():
        print(f"{name:50} {share:.1%}")
    print(f"{rows} rows by the process that joined")
    if args.keep:
        rows_told = [
            {"who": name, "share of its time that it computed": f"{100 * share:.1f} %"} for name, share in told.items()
        ]
        keep("joining", rows_told, f"{rows} rows by the one that joined, two cores")


if __name__ == "__main__":
    sys.exit(main())
