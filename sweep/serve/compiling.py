"""Every rank finds the kernel compiled: one on each node compiles it, all at the same time."""

import time
from contextlib import nullcontext
from typing import Any

import numpy as np

from kernel.jit import compiling
from sweep.log import say
from sweep.machine import cache_folder
from sweep.plan import speed
from sweep.serve.messages import meet
from sweep.serve.worker import Job
from sweep.store import disk

SAY_EVERY = 10.0  # seconds between two lines
SMALLEST = {"N": 2, "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": 1.0}


def compile_once(comm: Any | None, job: Job) -> float:
    """Compile what the job needs unless the cache has it; how fast this core is (`speed`), on rank 0.

    Where all nodes have one cache, rank 0 compiles for all: file systems of a network mix up several writers.
    """
    if comm is None:
        return _compile(job)
    from mpi4py import MPI

    alone = comm.rank == 0
    if not comm.bcast(disk.is_shared(cache_folder()) if alone else None):
        node = comm.Split_type(MPI.COMM_TYPE_SHARED)
        alone = node.rank == 0
        node.Free()
    unit = _compile(job, loud=comm.rank == 0) if alone else 0.0
    meet(comm)
    if not alone:  # so that no rank's first batch waits for it
        _load(job)
    return unit


def _compile(job: Job, loud: bool = True) -> float:
    with compiling(_Told().functions) if loud else nullcontext():
        if job.model is None and not job.quantities:
            return speed.measure()
        _load(job)  # and not the paper's chain too, which would take as long again
        return speed.without_measuring()


def _load(job: Job) -> None:
    """Have what the job needs in memory, from the cache if it is there, by its first task's chain."""
    first = job.tasks.columns(np.zeros(1, np.int64))
    sites = {} if job.model is None or job.model.sites is None else {"N": job.model.sites}
    job.results_of({name: np.array([(SMALLEST | sites).get(name, first[name][0])]) for name in first})


class _Told:
    """Says that the kernel is being compiled, and now and then how far it is."""

    def __init__(self) -> None:
        self._next = 0.0

    def functions(self, count: int) -> None:
        """`count`: how many are compiled."""
        now = time.monotonic()
        if not count:
            say("compiling the kernel, once, in one to two minutes; the next run finds it in the cache")
        elif now >= self._next:
            say(f"compiling the kernel: {count} functions so far")
        else:
            return
        self._next = now + SAY_EVERY
