"""How this process was started: alone, under an MPI launcher, or under the wrong one."""

import contextlib
import ctypes
import os
import shutil
import signal
import sys
import threading
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from sweep.errors import InputError
from sweep.log import say
from sweep.site import schedulers

# How many processes each launcher says it has started, and which one this is. A scheduler's launcher adds its own.
SIZE_VARIABLES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS", "PALS_NRANKS")
RANK_VARIABLES = ("PMI_RANK", "OMPI_COMM_WORLD_RANK", "PALS_RANKID")
# By these an MPI library knows that it was started by a launcher, and by the last mpi4py that it is to leave MPI alone.
TRACES = ("PMI_", "PMIX_", "OMPI_", "PRTE_", "HYDRA_", "HYDI_", "MPI_", "PALS_", "MPI4PY_RC_INITIALIZE")

# UCX, by which MPICH and Open MPI reach other nodes, drops a connection that was cut for 16 s (idle 10 s, then three
# questions 2 s apart), and tells nobody. TCP itself goes on after a longer one; what is lost, sweep.serve.pulse finds.
KEEP_CONNECTIONS = "UCX_TCP_KEEPIDLE", "inf"
PARTING_MAX = 10.0  # seconds for MPI's last messages


def stated_rank(environment: Mapping[str, str]) -> int:
    """This process's rank by its launcher's word, before MPI is started; 0 when alone."""
    names = (*RANK_VARIABLES, *(each.rank_variable for each in schedulers.ALL))
    return max((number for number, _ in _numbers(environment, names)), default=0)


def stated_size(environment: Mapping[str, str]) -> tuple[int, str]:
    """The largest number of processes that a launcher's variable states, and that variable; (1, "") when alone."""
    return max(_numbers(environment, _size_variables()), key=lambda pair: pair[0], default=(1, ""))


def _size_variables() -> tuple[str, ...]:
    return (*SIZE_VARIABLES, *(each.size_variable for each in schedulers.ALL))


def _numbers(environment: Mapping[str, str], names: Iterable[str]) -> list[tuple[int, str]]:
    return [(int(text), name) for name in names if (text := environment.get(name, "")).isdecimal()]


def without_launcher(environment: Mapping[str, str]) -> dict[str, str]:
    """The environment of a program that does not take part in the run of the process that starts it."""
    return {name: value for name, value in environment.items() if not name.startswith(TRACES)}


def mpirun() -> str | None:
    """The one beside this Python, which belongs to its MPI, else one on the PATH; None where there is neither."""
    beside = Path(sys.executable).with_name("mpirun")
    return str(beside) if beside.exists() else shutil.which("mpirun")


def communicator() -> Any | None:
    """The world communicator, or None when this process is alone; InputError under a launcher that MPI ignores.

    Alone, mpi4py is not even imported: one process needs no MPI.
    """
    size, variable = stated_size(os.environ)
    if size == 1 and not any(name in os.environ for name in _size_variables()):
        for scheduler in schedulers.ALL:
            if idle := scheduler.idle(os.environ):
                say(idle)
        return None
    os.environ.setdefault(*KEEP_CONNECTIONS)
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
        others = "".join(f", or with the matching {each.launcher}" for each in schedulers.ALL if each.launcher)
        raise InputError(
            f"{variable}={size}, but MPI sees one process: this launcher belongs to another MPI, and every process "
            "would run the whole sweep. Start with the mpirun of the MPI that mpi4py uses "
            f"({MPI.get_vendor()[0]}){others}"
        )
    return world if world.size > 1 else None


def mpi_version(comm: Any | None) -> str:
    """Which MPI library this process uses."""
    if comm is None:
        return "none (one process)"
    from mpi4py import MPI

    return str(MPI.Get_library_version().splitlines()[0].strip("\0"))


def part(status: int) -> None:
    """End MPI before this process exits with `status`; where the other ranks cannot be reached, without it.

    MPICH may wait for ever in MPI_Finalize, where a connection is lost, or where the last messages were looked for now
    and then, as here, and not waited for: the barrier lets it finish what is under way.
    """
    mpi = sys.modules.get("mpi4py.MPI")
    if mpi is None or not mpi.Is_initialized() or mpi.Is_finalized():
        return
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):
            stream.flush()
    timer = threading.Timer(PARTING_MAX, os._exit, (status,))
    timer.daemon = True
    timer.start()
    mpi.COMM_WORLD.Barrier()
    ctypes.CDLL(mpi.__file__).MPI_Finalize()  # mpi4py's would let no other thread run, and so no timer
    timer.cancel()


def end_those_that_start(status: int) -> None:
    """End the other ranks, where a Ctrl-C ended this one before MPI was started: they would wait there for ever."""
    mpi = sys.modules.get("mpi4py.MPI")
    if stated_size(os.environ)[0] == 1 or (mpi is not None and mpi.Is_initialized()):
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # The others may have ended as this one did: it would wait for them, and no thread runs while MPI starts.
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(int(PARTING_MAX))
    with contextlib.suppress(ImportError, RuntimeError):
        from mpi4py import MPI

        from sweep.serve.messages import abort

        abort(MPI.COMM_WORLD, status)
    signal.alarm(0)
