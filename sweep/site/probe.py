"""What `sweep doctor` starts under mpirun and kills: ranks that write made-up rows until then.

python -m sweep.site.probe TABLE WRITER: every rank writes its share of a table, over and over, and never returns.
"""

import sys
from pathlib import Path

import numpy as np

from sweep.plan.tasks import Ids, Tasks
from sweep.schema import DONE, blank_of, seal
from sweep.site import launch
from sweep.store import writers

AXES = {"N": range(2, 66), "zeta_T": (0.0, 1e-3), "M_over_M0": (1.0,), "V_over_V0": (1.0, 2.0)}
TASKS = Tasks(AXES)
ROWS_PER_WRITE = 8
FLUSH_EVERY = 30.0  # seconds


def rows_of(ids: Ids) -> np.ndarray:
    """What a finished row of each of these tasks looks like; always the same bits."""
    rows = blank_of(TASKS.columns(ids))
    rows["ke_ratio"], rows["status"] = 1.0 / (1.0 + ids), DONE
    seal(rows)
    return rows


def main(path: str, name: str) -> None:
    """Write until killed. Prints once how many ranks it sees, and which MPI this is."""
    comm = launch.communicator()
    rank, size = (0, 1) if comm is None else (comm.rank, comm.size)
    if rank == 0:
        sys.stdout.write(f"{size} {launch.mpi_version(comm)}\n")
        sys.stdout.flush()
    writer = writers.Mpio(Path(path), comm, FLUSH_EVERY) if name == "mpio" else writers.Gather(Path(path), FLUSH_EVERY)
    mine = np.arange(rank, len(TASKS), size) if name == "mpio" else np.arange(len(TASKS))
    while True:
        for first in range(0, len(mine), ROWS_PER_WRITE):
            ids = mine[first : first + ROWS_PER_WRITE]
            if name == "mpio" or rank == 0:
                writer.write(ids, rows_of(ids))


if __name__ == "__main__":
    main(*sys.argv[1:])
