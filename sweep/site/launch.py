"""How this process was started: alone, under an MPI launcher, or under the wrong one."""

import os
import warnings
from collections.abc import Mapping
from typing import Any

from sweep.errors import InputError
from sweep.log import say

# How many processes each launcher says it has started.
SIZE_VARIABLES = (
    "PMI_SIZE",
    "OMPI_COMM_WORLD_SIZE",
    "MPI_LOCALNRANKS",
    "PALS_NRANKS",
    "SLURM_STEP_NUM_TASKS",  # not SLURM_NTASKS: an allocation's shell has it too
)

RANK_VARIABLES = ("PMI_RANK", "OMPI_COMM_WORLD_RANK", "PALS_RANKID", "SLURM_PROCID")


def rank_told(environment: Mapping[str, str]) -> int:
    """This process's rank by its launcher's word, before MPI is started; 0 when alone."""
    told = [int(text) for name in RANK_VARIABLES if (text := environment.get(name, "")).isdecimal()]
    return max(told, default=0)


def launched_size(environment: Mapping[str, str]) -> tuple[int, str]:
    """The largest number of processes that a launcher's variable tells, and that variable; (1, "") when alone."""
    told = [(int(text), name) for name in SIZE_VARIABLES if (text := environment.get(name, "")).isdecimal()]
    return max(told, key=lambda pair: pair[0], default=(1, ""))


def _say_what_is_idle(environment: Mapping[str, str]) -> None:
    """A job's shell (salloc, sbatch) may start one process on purpose, or for want of a launcher."""
    if (text := environment.get("SLURM_NTASKS", "")).isdecimal() and int(text) > 1:
        say(f"SLURM_NTASKS={text}, but this is one process, started without mpirun or srun: the others stay idle")


def communicator() -> Any | None:
    """The world communicator, or None when this process is alone; InputError under a launcher that MPI ignores.

    Alone, mpi4py is not even imported: one process needs no MPI.
    """
    size, variable = launched_size(os.environ)
    if size == 1 and not any(name in os.environ for name in SIZE_VARIABLES):
        _say_what_is_idle(os.environ)
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # mpi4py's of a foreign launcher: ours below says more
            from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        if size == 1:
            return None
        raise InputError(f"{variable}={size}, but mpi4py finds no MPI library ({error}); see sweep's README") from None
    world = MPI.COMM_WORLD
    if world.size == 1 and size > 1:
        raise InputError(
            f"{variable}={size}, but MPI sees one process: this launcher belongs to another MPI, and every process "
            "would run the whole sweep. Start with the mpirun of the MPI that mpi4py uses "
            f"({MPI.get_vendor()[0]}), or with the matching srun --mpi=... (srun --mpi=list)"
        )
    return world if world.size > 1 else None


def mpi_version(comm: Any | None) -> str:
    """Which MPI library this process uses."""
    if comm is None:
        return "none (one process)"
    from mpi4py import MPI

    return str(MPI.Get_library_version().splitlines()[0].strip("\0"))
