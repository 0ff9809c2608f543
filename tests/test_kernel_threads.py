"""Claims about tasks on several threads: the same rows in the same order, at the same time."""

import threading

import numpy as np
import pytest

import kernel
from kernel.threads import AT_ONCE, in_threads


def tasks(count, seed):
    rng = np.random.default_rng(seed)
    ranges = {"zeta_T": (1e-5, 1.0), "M_over_M0": (0.1, 10), "V_over_V0": (0.1, 10)}
    drawn = {name: np.exp(rng.uniform(*np.log(pair), count)) for name, pair in ranges.items()}
    return {"N": rng.integers(2, 40, count)} | drawn


@pytest.mark.slow
def test_the_bits_do_not_depend_on_the_number_of_workers():
    some = tasks(5 * AT_ONCE + 3, np.random.SeedSequence().entropy)
    some["zeta_T"][7] = -1.0
    one, two, nine = (kernel.ke_ratios(some, 1e-2, workers=workers) for workers in (1, 2, 9))
    assert one.tobytes() == two.tobytes() == nine.tobytes()
    assert one["status"][7] == "bad_input"
    assert (one["status"] == "done").sum() == len(one) - 1


@pytest.mark.parametrize("count", [AT_ONCE + 1, 10 * AT_ONCE])
def test_parts_are_computed_at_the_same_time_and_stand_in_order(count):
    meeting = threading.Barrier(2, timeout=60)

    def compute(part):
        meeting.wait()
        return np.arange(count)[part]

    assert in_threads(count, 2, compute).tolist() == list(range(count))


@pytest.mark.slow
@pytest.mark.parametrize("work", [kernel.ke_ratios, kernel.measure])
def test_who_asks_for_no_threads_gets_none(work, monkeypatch):
    monkeypatch.setattr("kernel.threads.ThreadPoolExecutor", None)
    many = {"N": [2] * 2 * AT_ONCE, "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": 1.0}
    rows = work(many, accuracy=0.1, certify=False)
    assert (rows["status"] == "done").all()


@pytest.mark.parametrize("workers", [1, 4])
def test_no_tasks_give_no_rows(workers):
    assert len(kernel.ke_ratios({name: [] for name in kernel.task.PARAMETERS}, workers=workers)) == 0


def test_what_a_part_raises_is_raised():
    def compute(part):
        raise MemoryError

    with pytest.raises(MemoryError):
        in_threads(100 * AT_ONCE, 3, compute)
