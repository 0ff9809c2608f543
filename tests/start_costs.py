"""What one more rank costs besides its messages, measured on this machine: for `python -m tests.scale`."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sweep.plan.tasks import Tasks
from sweep.schema import DONE, blank_of, seal
from sweep.serve.pulse import BEAT
from sweep.store import table
from sweep.store.writers import Gather

ROWS, BATCH = 1 << 17, 32  # rows of a table that rank 0 writes for all, and of a batch
# A rank as it starts: every module, and the kernel from its cache. Files are counted by Python's own audit.
START = """
import sys, time
opened = set()
sys.addaudithook(lambda event, args: opened.add(str(args[0])) if event == "open" else None)
from sweep.conduct import run
from kernel import ke_ratio
ke_ratio(5, 1e-3, 1.0, 1.0)
print(len(opened), time.process_time())
"""
METADATA_RATE = 20_000  # files that a parallel file system opens a second, all nodes together: assumed, not measured


class Costs(NamedTuple):
    """Of one rank, and of one row."""

    files: int  # that a rank opens as it starts
    seconds: float  # processor time of its start, from a kernel that is compiled
    row: float  # processor seconds of rank 0 for a row that it writes for another


def measured() -> Costs:
    """All of them; the kernel must be compiled."""
    answers = [subprocess.run([sys.executable, "-c", START], capture_output=True, check=True, text=True, timeout=600)]
    files, seconds = answers[-1].stdout.split()
    with tempfile.TemporaryDirectory() as folder:
        return Costs(int(files), float(seconds), written(Path(folder, "t.h5")))


def written(path: Path) -> float:
    """Processor seconds of a row that rank 0 writes, in batches from all over the table."""
    tasks = Tasks({"N": range(2, 10), "zeta_T": np.arange(ROWS / 8) / ROWS, "M_over_M0": [1.0], "V_over_V0": [1.0]})
    table.create(path, tasks, {})
    rows = blank_of(tasks.columns(np.arange(BATCH)))
    rows["status"] = DONE
    seal(rows)
    writer, order = Gather(path, 3600.0), np.random.default_rng(0).permutation(ROWS).reshape(-1, BATCH)
    start = time.thread_time()
    for ids in order:
        writer.write(ids, rows)
    seconds = time.thread_time() - start
    writer.close()
    return seconds / ROWS


def told(ranks: int, costs: Costs, rate: float, task: float, efficiency: float, shards: float) -> dict[str, str]:
    """A line of the documentation's table. `rate`: requests a second of the master; `task`: mean seconds of a task."""
    return {
        "ranks": str(ranks),
        "files opened at the start": f"{ranks * costs.files:.2g}",
        "s of a file system for them (assumed rate)": f"{ranks * costs.files / METADATA_RATE:.0f}",
        "rank 0: share of its time for signs of life": f"{ranks / BEAT / rate:.1%}",
        "and for rows, if it writes all": f"{ranks / task * costs.row:.0%}",
        "efficiency, one master (simulated)": f"{efficiency:.0%}",
        "in shards (simulated)": "-" if shards != shards else f"{shards:.0%}",
    }
