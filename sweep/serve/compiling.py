"""Every rank finds the kernel compiled: two on each node compile it, all nodes at the same time."""

from typing import Any

import numpy as np

from kernel.cache import why_not_kept
from kernel.jit import compiling
from sweep.log import Compiling
from sweep.machine import cache_folder
from sweep.plan import speed
from sweep.plan.search import SCREEN
from sweep.serve.messages import meet
from sweep.serve.worker import Job
from sweep.store import disk

SMALLEST = {"N": 2, "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": 1.0}


def compile_once(comm: Any | None, job: Job) -> float:
    """Compile what the job needs unless the cache has it; how fast this core is (`speed`), on rank 0.

    On each node two ranks do it, a half each. Where all nodes have one cache rank 0 does, for all: file systems of a
    network mix up several writers.
    """
    if comm is None:
        return _compile(job, _Told())
    from mpi4py import MPI

    alone = comm.bcast(disk.is_shared(cache_folder()) if comm.rank == 0 else None)
    node = comm.Dup() if alone else comm.Split_type(MPI.COMM_TYPE_SHARED)
    pair = node.Split(0 if node.rank < 2 and not alone else MPI.UNDEFINED)
    unit = 0.0
    if node.rank == 0:
        unit = _compile(job, _Told(comm.rank == 0, job, pair if pair and pair.size == 2 else None))
    elif pair and _asked(pair, None):
        job.compile_half(second=True)
        meet(pair)
    meet(comm)
    if node.rank > 0:  # so that no rank's first batch waits for it
        _load(job)
    for each in filter(None, (pair, node)):
        each.Free()
    return unit


def what_follows() -> str:
    """What the compiling of this run means for the next one, for the log."""
    if not (why := why_not_kept()):
        return "the next run finds it in the cache"
    remedy = "make room there, or set NUMBA_CACHE_DIR"
    return f"it cannot be kept in {cache_folder()} ({why}), so every start compiles it: {remedy}"


def _asked(pair: Any, help_needed: bool | None) -> bool:
    """Whether the node's first rank needs the second, which sleeps until that is known; the second gives None."""
    meet(pair)
    needed: bool = pair.bcast(help_needed)
    return needed


def _compile(job: Job, told: "_Told") -> float:
    with compiling(told.functions):
        if job.model is None and not job.quantities:
            unit = speed.measure()
            if job.screens:
                _load(job)
        else:
            _load(job)  # and not the paper's chain too, which would take as long again
            unit = speed.without_measuring()
    told.end()
    return unit


def _load(job: Job) -> None:
    """Have what the job needs in memory, from the cache if it is there, by its first task's chain."""
    first = job.tasks.columns(np.zeros(1, np.int64))
    sites = {} if job.model is None or job.model.sites is None else {"N": job.model.sites}
    columns = {name: np.array([(SMALLEST | sites).get(name, first[name][0])]) for name in first}
    job.results_of(columns)
    if job.screens:
        job.results_of(columns, SCREEN)


class _Told:
    """What happens as the kernel is compiled: it is said, now and then how far it is, and a second rank is asked in."""

    def __init__(self, loud: bool = True, job: Job | None = None, pair: Any | None = None) -> None:
        self._say = Compiling() if loud else None
        self._job, self._pair = job, pair

    def functions(self, count: int) -> None:
        """`count`: how many are compiled."""
        if self._say:
            self._say(count)
        if not count and self._pair and self._job:
            pair, self._pair = self._pair, None
            _asked(pair, True)
            self._job.compile_half(second=False)
            meet(pair)

    def end(self) -> None:
        """All is compiled, or was."""
        if self._pair:
            _asked(self._pair, False)
