"""Whether all ranks are still there: each tells rank 0 that it lives, over the connections that the work takes.

Libraries of MPI drop a connection that was cut for some seconds without a word to either end, and a machine without
power says nothing either: both ends would wait for ever. Here every wait ends after SILENCE_MAX, whatever the
main thread does meanwhile; the sweep ends with STOPPED_EARLY and can be resumed.
"""

import os
import platform
import signal
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, NoReturn

import numpy as np

from sweep.errors import STOPPED_EARLY, InputError
from sweep.log import say
from sweep.serve.messages import abort
from sweep.serve.watch import NodeWatch

BEAT = 5.0  # seconds between two signs of life
SILENCE_MAX = 60.0  # seconds: Gluster holds processes still for 42, and 30 are a switch that starts again
DISK_MAX = 300.0  # seconds of one write: parallel file systems take minutes to replace a dead server
LOOK_EVERY = 0.25  # seconds between looks for messages
# Seconds between two looks that count as silence of others, at most: what is longer this rank was held still itself.
HELD_STILL_MAX = 4 * LOOK_EVERY
ABORT_MAX = 5  # seconds for a launcher to end all ranks, before this one ends itself
ALIVE, BYE = 0, 1  # what a rank tells


class Pulse:
    """Of one rank, from the start of a run to its end; made and ended by all ranks together."""

    def __init__(self, comm: Any | None) -> None:
        self.hosts = [platform.node()]  # of all ranks; known to rank 0
        self.watch: NodeWatch | None = None  # to be told that this rank ends the job
        self._all, self._ending = comm, threading.Event()
        self._stalled: Callable[[], float] = lambda: 0.0
        self._thread: threading.Thread | None = None
        if comm is None:
            self._thread = threading.Thread(target=self._run, args=(self._look_at_disk,), daemon=True)
        else:
            self.hosts = comm.gather(self.hosts[0]) or []
            if _threads_may_talk():
                self._comm = comm.Dup()  # messages of the pulse and of the work never meet
                talk = self._beat if comm.rank else self._listen
                self._thread = threading.Thread(target=self._run, args=(talk,), daemon=True)
            elif comm.rank == 0:
                say("this MPI lets one thread talk: a rank that falls silent will not be noticed")
        if self._thread is not None:
            self._thread.start()

    def __enter__(self) -> "Pulse":
        return self

    def __exit__(self, kind: type[BaseException] | None, _error: object, _trace: TracebackType | None) -> None:
        self._ending.set()
        if self._thread is not None and (kind is None or issubclass(kind, InputError)):
            self._thread.join()

    def watch_disk(self, stalled: Callable[[], float]) -> None:
        """From now on `stalled` tells for how many seconds the disk has not answered."""
        self._stalled = stalled

    def give_up(self, why: str) -> NoReturn:
        """End all ranks, from any thread of any of them, whatever it waits for."""
        say(f"{why}, which ends the job; what was reported done is kept, run again to go on")
        if self.watch is not None:
            self.watch.hush()
        signal.alarm(ABORT_MAX)  # which kills: an abort may wait for the network, too, and lets no thread run meanwhile
        if self._all is not None:
            abort(self._all, STOPPED_EARLY)
        os._exit(STOPPED_EARLY)

    def _run(self, talk: Callable[[], None]) -> None:
        try:
            talk()
        except Exception as error:  # MPI's, of a connection that is lost
            self.give_up(f"a rank is lost ({error})")

    def _look_at_disk(self) -> None:
        while not self._ending.wait(1.0):
            self._check_disk()

    def _check_disk(self) -> None:
        if (seconds := self._stalled()) > DISK_MAX:
            self.give_up(f"on {platform.node()} the table's disk has not answered for {seconds:.0f} s")

    def _beat(self) -> None:
        """Of a worker: one beat after the other, each answered by rank 0."""
        assert self._all is not None
        word, silence, answer = np.empty(1, np.int64), Silence(1), np.empty(1, np.int64)
        while True:
            last = self._ending.is_set()
            word[0] = BYE if last else ALIVE
            receiving = None if last else self._comm.Irecv(answer, 0)
            sending = self._comm.Isend(word, 0)
            while not sending.Test() or (receiving is not None and not receiving.Test()):
                time.sleep(LOOK_EVERY)
                self._check_disk()
                if silence.passed():
                    self.give_up(_lost(self._all.rank, platform.node(), 0, "its node"))
            if last:
                return
            silence.heard(0)
            self._ending.wait(BEAT)

    def _listen(self) -> None:
        """Of rank 0: answers every beat, until all workers have said goodbye."""
        from mpi4py import MPI

        word, status, silence = np.empty(1, np.int64), MPI.Status(), Silence(self._comm.size)
        silence.goodbye(0)
        answer = np.zeros(1, np.int64)
        answers: dict[int, Any] = {}  # the last request to each rank, which must not be forgotten under way
        request = self._comm.Recv_init(word, MPI.ANY_SOURCE)
        request.Start()
        while silence.expected:
            while silence.expected and request.Test(status):
                rank = status.source
                if rank in answers:
                    answers.pop(rank).Wait()  # it has arrived: MPI could not end with it under way
                if word[0] == BYE:
                    silence.goodbye(rank)
                else:
                    silence.heard(rank)
                    answers[rank] = self._comm.Isend(answer, rank)
                if silence.expected:
                    request.Start()
            if lost := silence.passed():
                self.give_up(_lost(0, self.hosts[0], lost[0], self.hosts[lost[0]], len(lost) - 1))
            self._check_disk()
            time.sleep(LOOK_EVERY)
        request.Free()


class Silence:
    """For how long each of `count` ranks has not been heard.

    Time in which this process was held, as schedulers do, does not count.
    """

    def __init__(self, count: int) -> None:
        self._seconds, self._last = np.zeros(count), time.monotonic()

    @property
    def expected(self) -> bool:
        """Whether anybody is."""
        return bool(np.isfinite(self._seconds).any())

    def heard(self, rank: int) -> None:
        """It lives."""
        self._seconds[rank] = 0.0

    def goodbye(self, rank: int) -> None:
        """It need not be heard any more."""
        self._seconds[rank] = -np.inf

    def passed(self) -> list[int]:
        """The ranks that are lost."""
        now = time.monotonic()
        self._seconds += min(now - self._last, HELD_STILL_MAX)
        self._last = now
        return np.flatnonzero(self._seconds > SILENCE_MAX).tolist()


def _threads_may_talk() -> bool:
    from mpi4py import MPI

    return bool(MPI.Query_thread() == MPI.THREAD_MULTIPLE)


def _lost(rank: int, host: str, other: int, its: str, more: int = 0) -> str:
    others = f", nor from {more} more" if more else ""
    return f"rank {rank} on {host} has not heard from rank {other} on {its} for {SILENCE_MAX:.0f} s{others}"
