"""No rank waits for ever: one that falls silent, a disk that never answers, a stop that is not obeyed end the run."""

import signal
import subprocess
import sys
import time

import pytest

from sweep.serve import pulse
from sweep.serve.grace import Grace
from sweep.serve.pulse import SILENCE_MAX, Silence
from sweep.store.writers import Waiting

from .conftest import BIN, clean_environment

WAIT = 120.0  # seconds
SILENT = """
import os, signal, sys, time
from mpi4py import MPI
from sweep.serve import pulse
pulse.BEAT, pulse.SILENCE_MAX, pulse.LOOK_EVERY = 0.1, 2.0, 0.05
comm = MPI.COMM_WORLD
with pulse.Pulse(comm):
    comm.Barrier()
    if comm.rank == int(sys.argv[1]):
        os.kill(os.getpid(), signal.SIGSTOP)
    comm.recv(source=(comm.rank + 1) % comm.size)  # for ever, as nobody sends
"""
LOST = """
import time
from sweep.serve import pulse
class Lost:
    def Abort(self, status):
        time.sleep(600)
pulse.ABORT_MAX = 1
ended = pulse.Pulse(None)
ended._all = Lost()
ended.give_up("the network is gone")
"""


@pytest.mark.mpi
@pytest.mark.parametrize("silent", [0, 2])
def test_a_rank_that_falls_silent_ends_the_run_with_75_and_is_named(silent):
    command = [BIN / "mpirun", "-n", "3", sys.executable, "-P", "-c", SILENT, str(silent)]
    answer = subprocess.run(command, env=clean_environment(), capture_output=True, text=True, timeout=WAIT, check=False)
    assert answer.returncode == 75, answer.stderr
    assert f" has not heard from rank {silent} on " in answer.stderr
    assert "what was reported done is kept, run again to go on" in answer.stderr


def test_only_ranks_from_whom_something_is_expected_can_be_lost(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(pulse.time, "monotonic", lambda: clock[0])
    silence = Silence(3)
    silence.goodbye(0)
    for _ in range(round(SILENCE_MAX / 0.5)):
        clock[0] += 0.5
        assert silence.passed() == []
        silence.heard(1)
    clock[0] += 0.5
    assert silence.passed() == [2]
    silence.goodbye(1)
    silence.goodbye(2)
    assert not silence.expected


def test_time_in_which_a_process_is_held_is_no_silence(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(pulse.time, "monotonic", lambda: clock[0])
    silence = Silence(2)
    for _ in range(10):
        clock[0] += 100 * SILENCE_MAX  # a scheduler has suspended the job, once more
        assert silence.passed() == []


def test_a_write_that_does_not_return_is_seen_from_outside_with_its_age(tmp_path, monkeypatch):
    waiting, clock = Waiting(), [10.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    assert waiting.seconds() == 0.0
    with waiting.on(tmp_path):
        clock[0] = 17.0
        assert waiting.seconds() == 7.0
    assert waiting.seconds() == 0.0


def test_after_a_signal_what_is_under_way_has_ten_times_its_predicted_time_and_a_minute(monkeypatch):
    clock, asked = [0.0], []
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    ends = Grace(lambda: bool(asked))
    clock[0] = 1e6
    assert not ends.is_over(2.0)
    asked.append(1)
    assert not ends.is_over(2.0)
    clock[0] += 60.0 + 10 * 2.0
    assert not ends.is_over(2.0)
    clock[0] += 0.1
    assert ends.is_over(2.0)


def test_a_rank_whose_abort_waits_for_the_network_ends_itself():
    command = [sys.executable, "-P", "-c", LOST]
    answer = subprocess.run(command, env=clean_environment(), capture_output=True, text=True, timeout=WAIT, check=False)
    assert answer.returncode == -signal.SIGALRM, answer.stderr
    assert "the network is gone, which ends the job" in answer.stderr
