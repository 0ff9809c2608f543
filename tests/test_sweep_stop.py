"""A sweep that is asked to stop finishes what runs, exits 75, and goes on later; its status can be read meanwhile."""

import json
import os
import signal
import time
from pathlib import Path

import pytest

from sweep.errors import InputError
from sweep.tell import report

from .waiting import WAIT, wait_for_rows

pytestmark = pytest.mark.mpi

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)


def live_status(sweep, process) -> dict:
    """`sweep status` from another process, as soon as rows are finished."""
    until = time.monotonic() + WAIT
    while time.monotonic() < until:
        assert process.poll() is None, "the run ended before it could be asked"
        answer = sweep("status", "t.h5", "--json")
        if answer.returncode == 0 and (told := json.loads(answer.stdout))["done"] > 0 and told["rate_per_s"]:
            return told
    raise AssertionError("no row was finished")


def started(path) -> bool:
    """Whether a run has handed out its first task."""
    try:
        return bool(report.show(path)["runs"])
    except InputError:
        return False


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("ranks", [1, 3])
def test_a_signal_stops_the_run_with_75_and_keeps_what_is_finished(start, slow_spec, tmp_path, ranks, number):
    process = start("run", slow_spec, "-o", "t.h5", ranks=ranks)
    wait_for_rows(tmp_path / "t.h5", process)
    process.send_signal(number)
    out, err = process.communicate(timeout=WAIT)
    told = report.status(tmp_path / "t.h5")
    assert process.returncode == 75
    assert f"{told['done']} done, 0 failed, {told['left']} left; wall time" in out
    assert 0 < told["done"] < 492
    assert told["running"] is False
    assert "Traceback" not in err


def ranks_of(launcher: int) -> list[int]:
    """The processes at the leaves below a launcher; itself where it has launched nothing."""
    children = Path(f"/proc/{launcher}/task/{launcher}/children").read_text().split()
    return [leaf for child in children for leaf in ranks_of(int(child))] or [launcher]


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_signal_during_start_up_stops_the_run_with_75_too(start, slow_spec, tmp_path, ranks):
    process = start("run", slow_spec, "-o", "t.h5", ranks=ranks)
    until = time.monotonic() + WAIT
    while not list(tmp_path.glob(".t.h5.lock")) and time.monotonic() < until:
        time.sleep(0.001)
    # To every rank, as mpirun does: in its own first second mpirun has been seen to swallow a signal.
    for pid in ranks_of(process.pid):
        os.kill(pid, signal.SIGTERM)
    _, err = process.communicate(timeout=WAIT)
    assert process.returncode == 75
    assert "Traceback" not in err
    assert report.status(tmp_path / "t.h5")["left"] > 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["slow.toml", "t.h5"]


def test_a_stopped_run_goes_on_and_completes(sweep, start, slow_spec, tmp_path):
    process = start("run", slow_spec, "-o", "t.h5", ranks=3)
    wait_for_rows(tmp_path / "t.h5", process)
    process.send_signal(signal.SIGUSR1)
    assert process.wait(WAIT) == 75
    left = report.status(tmp_path / "t.h5")["left"]
    again = sweep("run", slow_spec, "-o", "t.h5", ranks=2)
    assert again.returncode == 0
    assert f"492 tasks, {left} left; " in again.stderr
    assert again.stdout.startswith("492 done, ")


@pytest.mark.parametrize("ranks", [1, 2])
def test_status_of_a_running_sweep_says_running_and_how_long(sweep, start, slow_spec, tmp_path, ranks):
    text = slow_spec.read_text().replace("rtol = 1e-7", "rtol = 1e-10")  # so long that a status comes before its end
    slow_spec.write_text(text)
    process = start("run", slow_spec, "-o", "t.h5", ranks=ranks)
    told = live_status(sweep, process)
    assert told["running"] is True
    assert told["done"] + told["left"] == told["tasks"] == 492
    assert 0 < told["rate_per_s"] < 1e4
    assert 0 < told["eta_s"] < 1e4
    assert process.wait(WAIT) == 0
    told = report.status(tmp_path / "t.h5")
    assert (told["running"], told["left"], told["eta_s"]) == (False, 0, None)


def test_a_second_signal_ends_a_single_process_at_once(start, slow_spec, tmp_path):
    text = slow_spec.read_text().replace("{ linear = [60, 160], points = 41 }", "[5, 6, 8000]")
    slow_spec.write_text(text)  # the longest task goes out first, and takes far longer than this test
    process = start("run", slow_spec, "-o", "t.h5")
    until = time.monotonic() + WAIT
    while not started(tmp_path / "t.h5") and time.monotonic() < until:
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGINT)
    time.sleep(0.5)
    assert process.poll() is None
    os.kill(process.pid, signal.SIGINT)
    assert process.wait(30) == -signal.SIGINT
