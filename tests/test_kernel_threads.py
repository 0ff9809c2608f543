"""Claims about tasks on several threads: the same rows in the same order, at the same time."""

import signal
import threading
import time

import numpy as np
import pytest

import kernel
from kernel import threads
from kernel.threads import in_threads

MANY = 80  # tasks


def tasks(count, seed):
    rng = np.random.default_rng(seed)
    ranges = {"zeta_T": (1e-5, 1.0), "M_over_M0": (0.1, 10), "V_over_V0": (0.1, 10)}
    drawn = {name: np.exp(rng.uniform(*np.log(pair), count)) for name, pair in ranges.items()}
    return {"N": rng.integers(2, 40, count)} | drawn


@pytest.mark.slow
def test_the_bits_do_not_depend_on_the_number_of_workers():
    some = tasks(MANY + 3, np.random.SeedSequence().entropy)
    some["zeta_T"][7] = -1.0
    one, two, nine = (kernel.ke_ratios(some, 1e-2, workers=workers) for workers in (1, 2, 9))
    assert one.tobytes() == two.tobytes() == nine.tobytes()
    assert one["status"][7] == "bad_input"
    assert (one["status"] == "done").sum() == len(one) - 1


@pytest.mark.parametrize("count", [2, 10 * MANY])
def test_parts_are_computed_at_the_same_time_and_stand_in_order(count):
    meeting, met = threading.Barrier(2, timeout=60), set()

    def compute(part):
        if threading.get_ident() not in met:
            met.add(threading.get_ident())
            meeting.wait()
        return np.arange(count)[part]

    assert in_threads(count, 2, compute).tolist() == list(range(count))


@pytest.mark.slow
@pytest.mark.parametrize("work", [kernel.ke_ratios, kernel.measure])
def test_who_asks_for_no_threads_gets_none(work, monkeypatch):
    monkeypatch.setattr("kernel.threads.ThreadPoolExecutor", None)
    many = {"N": [2] * MANY, "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": 1.0}
    rows = work(many, accuracy=0.1, certify=False)
    assert (rows["status"] == "done").all()


@pytest.mark.parametrize("workers", [1, 4])
def test_no_tasks_give_no_rows(workers):
    assert len(kernel.ke_ratios({name: [] for name in kernel.task.PARAMETERS}, workers=workers)) == 0


def test_what_a_part_raises_is_raised():
    def compute(part):
        raise MemoryError

    with pytest.raises(MemoryError):
        in_threads(MANY, 3, compute)


@pytest.mark.parametrize("workers", [1, 3])
def test_ctrl_c_is_obeyed_between_two_parts_and_what_is_not_begun_is_not_computed(workers, monkeypatch):
    monkeypatch.setattr(threads, "SECONDS_AT_ONCE", 0.0)  # as of tasks that take long: one at a time
    begun = []

    def compute(part):
        begun.append(part)
        if len(begun) == 5:
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        time.sleep(0.0 if workers == 1 else 0.02)  # what others begin meanwhile they end
        return np.arange(MANY)[part]

    with pytest.raises(KeyboardInterrupt):
        in_threads(MANY, workers, compute)
    assert 5 <= len(begun) < MANY / 2
    assert all(part.stop - part.start == 1 for part in begun)


def test_parts_double_while_they_are_quick():
    sizes = []

    def compute(part):
        sizes.append(part.stop - part.start)
        return np.arange(1000)[part]

    assert in_threads(1000, 1, compute).tolist() == list(range(1000))
    assert sizes[:8] == [1, 2, 4, 8, 16, 32, 64, 128]
